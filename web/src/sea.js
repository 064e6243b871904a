// The waves of a recorded scene, long-crested: z = level + r(t) sum a cos(w t - k X + e), X along their way.

import { Table } from "./data.js";

const CELLS = 24; // of the longest waves' length, as the surface is drawn
const LEAST = 2; // cells that a wave has at least, or it is left out: it would look longer
const MOST = 40_000; // places of the surface
const WORK = 4e6; // sines at places along the waves in one picture

const way = (direction) => [Math.cos(direction), Math.sin(direction)];

export class Sea {
  constructor(waves, block) {
    this.runs = waves.runs;
    const table = new Table(block, waves.data);
    this.sines = waves.runs.map((_, run) => [0, 1, 2, 3].map((what) => table.row(run, what)));
    this.show(0, 0);
  }

  show(run, time) {
    Object.assign(this, { run, time });
  }

  // how many cells the sides (m) of the picture have along x and y, so that the waves of any run are seen
  cells(sides) {
    let counts = sides.map((side, axis) => {
      const wanted = this.runs.map(({ direction }, run) => {
        const [amplitude, , number] = this.sines[run];
        const longest = number[amplitude.indexOf(Math.max(...amplitude))];
        return (CELLS * side * longest * Math.abs(way(direction)[axis])) / (2 * Math.PI);
      });
      return Math.max(Math.ceil(Math.max(...wanted) - 1e-6), 1);
    });
    const room = Math.sqrt(MOST / counts.reduce((product, count) => product * count, 1));
    if (room < 1) {
      const along = counts.indexOf(Math.max(...counts)), across = 1 - along;
      const fewer = Math.max(Math.floor(counts[across] * room), 1);
      counts = counts.map((count, axis) => (axis === across ? fewer : Math.min(count, Math.floor(MOST / fewer))));
    }
    this.finest = sides.map((side, axis) => side / counts[axis]);
    return counts;
  }

  // which sines the cells can show
  shown(run) {
    const along = way(this.runs[run].direction);
    return Array.from(this.sines[run][2].keys()).filter((n) => along.every((share, axis) =>
      LEAST * this.finest[axis] * this.sines[run][2][n] * Math.abs(share) <= 2 * Math.PI));
  }

  // heights (m) at places x, y (m), two arrays as long: by angles that are known along a row of places
  heights(x, y) {
    const { ramp, level, direction } = this.runs[this.run], [amplitude, omega, number, phase] = this.sines[this.run];
    const [cx, cy] = way(direction), { time } = this;
    const share = time < ramp ? Math.sin((Math.PI * time) / (2 * ramp)) ** 2 : 1;
    const along = Float64Array.from(x, (value, k) => cx * value + cy * y[k]);
    const [low, high] = along.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, -Infinity]);
    const span = high - low;
    const shown = this.shown(this.run), shortest = Math.max(...shown.map((n) => number[n]), 0);
    const wanted = Math.ceil((CELLS * span * shortest) / (2 * Math.PI)) + 2;
    const count = span > 0 ? Math.ceil(Math.min(wanted, Math.max(WORK / (shown.length + 1), 400))) : 1;
    const step = span / Math.max(count - 1, 1);
    const row = new Float64Array(count);
    for (const n of shown) {
      const first = omega[n] * time + phase[n] - number[n] * low, turn = -number[n] * step;
      let c = amplitude[n] * Math.cos(first), s = amplitude[n] * Math.sin(first);
      const ct = Math.cos(turn), st = Math.sin(turn);
      for (let k = 0; k < count; k++) {
        row[k] += c;
        [c, s] = [c * ct - s * st, s * ct + c * st];
      }
    }
    return along.map((value) => {
      const at = step > 0 ? (value - low) / step : 0, k = Math.min(Math.floor(at), Math.max(count - 2, 0));
      const next = row[Math.min(k + 1, count - 1)];
      return level + share * (row[k] + (at - k) * (next - row[k]));
    });
  }
}
