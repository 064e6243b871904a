// The waves of a recorded scene, long-crested: z = level + r(t) sum a cos(w t - k X + e), X along their way.

import { Table } from "./data.js";

const CELLS = 24; // of the longest waves' length, as the surface is drawn
const MOST = 160; // cells along a side of the picture

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

  // how many cells a side (m) of the picture has, along x or y, so that the waves of any run are seen
  cells(side, axis) {
    const wanted = this.runs.map(({ direction }, run) => {
      const [amplitude, , number] = this.sines[run];
      const longest = number[amplitude.indexOf(Math.max(...amplitude))];
      return (CELLS * side * longest * Math.abs(way(direction)[axis])) / (2 * Math.PI);
    });
    return Math.min(Math.max(Math.ceil(Math.max(...wanted) - 1e-6), 1), MOST);
  }

  // heights (m) at places x, y (m), two arrays as long: by angles that are known along a row of places
  heights(x, y) {
    const { ramp, level, direction } = this.runs[this.run], [amplitude, omega, number, phase] = this.sines[this.run];
    const [cx, cy] = way(direction), { time } = this;
    const share = time < ramp ? Math.sin((Math.PI * time) / (2 * ramp)) ** 2 : 1;
    const along = Float64Array.from(x, (value, k) => cx * value + cy * y[k]);
    const low = Math.min(...along), span = Math.max(...along) - low;
    const count = span > 0 ? 4 * MOST : 1, step = span / Math.max(count - 1, 1);
    const row = new Float64Array(count);
    for (let n = 0; n < amplitude.length; n++) {
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
