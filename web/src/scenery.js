// Lines and bodies of a recorded file on the stage, at any time between its frames.

import { between, endOf } from "./between.js";
import { colour, shades } from "./palette.js";
import { css } from "./dom.js";
import { Table } from "./data.js";
import { isDark } from "./shell.js";

export class Scenery {
  constructor(head, block, stage) {
    this.stage = stage;
    this.tied = head.surroundings[0].points;
    const table = (how) => (how ? new Table(block, how) : null);
    this.time = table(head.time.data).row();
    this.frames = head.frames.map((k) => this.time[k]);
    this.lines = head.lines.map((line) => ({ ...line, position: line.position.map(table),
      tension: table(line.tension), speed: table(line.speed), place: table(line.place),
      middle: table(line.middle) }));
    this.bodies = head.bodies.map((body) => ({ ...body, position: body.position.map(table),
      attitude: body.attitude?.map(table) }));
  }

  // what all runs shown take up together, so that the camera need not move between them
  box(runs) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const reach = (k, [a, b]) => {
      if (a < low[k]) low[k] = a;
      if (b > high[k]) high[k] = b;
    };
    for (const run of runs) {
      for (const line of this.lines) line.position.forEach((t, k) => reach(k, t.range(run)));
      for (const body of this.bodies) {
        for (let frame = 0; frame < this.frames.length; frame++) {
          const axes = rotation(body.attitude?.map((t) => t.at(run, frame)));
          body.position.forEach((t, k) => {
            const at = t.at(run, frame), [a, b] = extent(body.size[run], body.points[run], axes[k]);
            reach(k, [at + a, at + b]);
          });
        }
      }
    }
    return low[0] <= high[0] ? { low, high } : { low: [0, 0, 0], high: [1, 1, 1] };
  }

  build(run, other) {
    const { stage } = this;
    stage.clear();
    for (const which of other == null ? ["main"] : ["main", "other"]) {
      for (const line of this.lines) {
        const count = line.place.shape[1];
        const main = which === "main";
        stage.tube(`${which}/${line.name}`, count, line.diameter / 2, main ? 2.6 : 4.6, !main);
      }
      const ink = which === "main" ? "--body-edge" : "--second";
      const own = which === "main" ? run : other;
      for (const { name, size, points } of this.bodies) stage.solid(`${which}/${name}`, size[own], points[own], ink);
      for (const point of this.tied) stage.solid(`${which}/${point.name}`, null, [], ink);
    }
  }

  // lowest and highest tension (N) of a run, from zero where that is near
  range(run) {
    let low = Infinity, high = -Infinity;
    for (const line of this.lines) {
      if (!line.tension) continue;
      const [a, b] = line.tension.range(run);
      low = Math.min(low, a);
      high = Math.max(high, b);
    }
    return low <= high ? shades(low, high) : null;
  }

  frameAt(time) {
    const { frames } = this;
    let first = 0;
    while (first + 2 < frames.length && frames[first + 1] <= time) first++;
    const last = Math.min(first + 1, frames.length - 1);
    const span = frames[last] - frames[first];
    const share = span > 0 ? Math.min(Math.max((time - frames[first]) / span, 0), 1) : 0;
    return { first, last, share, nearest: share < 0.5 ? first : last };
  }

  draw(which, run, time, range) {
    const at = this.frameAt(time), { rise } = this.stage;
    const flat = which === "other" ? rgbOf(css("--second")) : null;
    for (const line of this.lines) {
      const key = `${which}/${line.name}`;
      const points = this.points(line.position, run, at);
      const rgb = new Float32Array(points.length);
      this.paint(rgb, flat, line.tension?.row(run, at.nearest), range);
      const ends = [points.slice(0, 3), endOf(points)];
      for (let k = 2; k < points.length; k += 3) points[k] *= rise;
      this.stage.tubes.get(key).update(points, rgb, this.stage.camera, (x, y, z) => this.stage.pixelAt(x, y, z));
      for (const point of this.tied) {
        if (point.line === line.name) this.stage.place(`${which}/${point.name}`, [...ends[point.at_end ? 1 : 0]]);
      }
    }
    for (const body of this.bodies) {
      const mix = (t) => between(t.at(run, at.first), t.at(run, at.last), at.share);
      const turn = body.attitude?.map(mix);
      const size = turn && Math.hypot(...turn);
      this.stage.place(`${which}/${body.name}`, body.position.map(mix), turn?.map((q) => q / size));
    }
  }

  points(position, run, { first, last, share }) {
    const count = position[0].shape[2];
    const points = new Float64Array(3 * count);
    position.forEach((table, k) => {
      const a = table.row(run, first), b = table.row(run, last);
      for (let i = 0; i < count; i++) points[3 * i + k] = between(a[i], b[i], share);
    });
    return points;
  }

  paint(rgb, flat, tension, range) {
    const dark = isDark(), count = rgb.length / 3;
    const plain = flat ?? (tension && range ? null : rgbOf(css("--first")));
    for (let i = 0; i < count; i++) {
      if (plain) {
        rgb.set(plain, 3 * i);
        continue;
      }
      const before = tension[Math.max(i - 1, 0)], after = tension[Math.min(i, count - 2)];
      const value = Number.isFinite(before) && Number.isFinite(after) ? (before + after) / 2
        : Number.isFinite(before) ? before : after;
      colour((value - range[0]) / (range[1] - range[0] || 1), dark, rgb, 3 * i);
    }
  }
}

// how far a box and its posts reach from its place along an axis, whose parts along its own axes are given
function extent(size, points, axis) {
  const half = axis.reduce((sum, share, j) => sum + (Math.abs(share) * (size?.[j] ?? 0)) / 2, 0);
  const posts = points.map((at) => axis.reduce((sum, share, j) => sum + share * at[j], 0));
  return [Math.min(-half, ...posts), Math.max(half, ...posts)];
}

// rows x, y, z of what turns a body's axes into those of space, from its attitude, a quaternion w, x, y, z
function rotation(attitude = [1, 0, 0, 0]) {
  const [w, x, y, z] = attitude.map((q) => q / Math.hypot(...attitude));
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]];
}

export function rgbOf(hex) {
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
}
