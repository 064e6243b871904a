// The room around the lines: a floor with a metre grid, a height scale, water surface and bed.

import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, Vector3 } from "three";
import { Bed } from "./bed.js";
import { css, el } from "./dom.js";
import { tickText, ticks } from "./format.js";

function steps(low, high, step) {
  const first = Math.ceil(low / step - 1e-6), last = Math.floor(high / step + 1e-6);
  return Array.from({ length: Math.max(last - first + 1, 0) }, (_, k) => (first + k) * step);
}

export class Frame {
  // box: { low: [x, y, z], high: [x, y, z] } in metres; sea: its waves, if any; rise: factor on heights
  constructor(group, labels, box, surroundings, sea) {
    Object.assign(this, { group, labels, box, surroundings, sea, rise: 1, made: [], texts: [] });
  }

  empty() {
    for (const thing of this.made) {
      this.group.remove(thing);
      thing.geometry.dispose();
      thing.material.dispose();
    }
    this.labels.replaceChildren();
    this.made = [];
    this.texts = [];
    this.water = null;
  }

  build() {
    this.empty();
    const { low, high } = this.box;
    const { bed, surface } = this.surroundings;
    // what one stands on: the bed, or the bottom of the room
    const ground = new Bed(bed ?? low[2]), floor = ground.range(low[0], high[0])[0];
    const wide = Math.max(high[0] - low[0], high[1] - low[1]);
    const { step } = ticks(0, wide, 8);
    const x = steps(low[0], high[0], step), y = steps(low[1], high[1], step);
    const ends = [low[0], high[0], low[1], high[1]];
    const lines = [];
    for (const at of x) lines.push([at, ends[2], ground.at(at)], [at, ends[3], ground.at(at)]);
    for (const at of y) lines.push(...along(ground, ends, at));
    this.add(lines, "--grid");
    this.outline(ends, ground, "--grid");
    const heights = ticks(Math.min(low[2], floor), high[2], 4);
    this.corners = [[ends[0], ends[2]], [ends[0], ends[3]], [ends[1], ends[2]], [ends[1], ends[3]]];
    this.scale = { x, y, z: heights.at.filter((z) => z >= floor - 1e-9), floor, ground, ends, step,
      zStep: heights.step };
    if (bed != null) this.sheet(ends, ground, "--bed", 0.45);
    if (surface != null && surface <= high[2] + (high[2] - low[2])) {
      if (this.sea) this.waves(ends);
      else {
        const level = new Bed(surface);
        this.sheet(ends, level, "--water", 0.16);
        this.outline(ends, level, "--water-edge");
      }
    }
    for (const axis of ["x", "y", "z"]) {
      const at = this.scale[axis], each = axis === "z" ? this.scale.zStep : step;
      for (const value of at) this.label(tickText(value, each), axis, value);
      this.label(`${axis} (m)`, axis, null);
    }
    this.ruler = this.add(new Array(2 * (1 + this.scale.z.length)).fill([0, 0, 0]), "--axis");
  }

  add(points, colour) {
    const flat = new Float32Array(points.flatMap(([a, b, c]) => [a, b, c * this.rise]));
    const shape = new BufferGeometry().setAttribute("position", new BufferAttribute(flat, 3));
    return this.put(new LineSegments(shape, edge(colour)));
  }

  put(thing) {
    thing.frustumCulled = false;
    this.group.add(thing);
    this.made.push(thing);
    return thing;
  }

  sheet(ends, ground, colour, opacity) {
    const across = ends.slice(2), flat = [], index = [];
    ground.places(ends[0], ends[1]).forEach((x, k) => {
      for (const y of across) flat.push(x, y, ground.at(x) * this.rise);
      if (k) index.push(2 * k - 2, 2 * k, 2 * k - 1, 2 * k, 2 * k + 1, 2 * k - 1);
    });
    const shape = new BufferGeometry().setAttribute("position",
      new BufferAttribute(new Float32Array(flat), 3)).setIndex(index);
    this.put(new Mesh(shape, plane(colour, opacity))).renderOrder = -1;
  }

  // the surface with its border and with lines along its crests and across them
  waves(ends) {
    const [nx, ny] = this.sea.cells([ends[1] - ends[0], ends[3] - ends[2]]);
    const x = [], y = [], faces = [], border = [], rows = [];
    for (let j = 0; j <= ny; j++) for (let i = 0; i <= nx; i++) {
      const at = j * (nx + 1) + i;
      x.push(ends[0] + (i / nx) * (ends[1] - ends[0]));
      y.push(ends[2] + (j / ny) * (ends[3] - ends[2]));
      if (i < nx) (j === 0 || j === ny ? border : rows).push(at, at + 1);
      if (j < ny) (i === 0 || i === nx ? border : rows).push(at, at + nx + 1);
      if (i < nx && j < ny) faces.push(at, at + 1, at + nx + 2, at, at + nx + 2, at + nx + 1);
    }
    const places = new BufferAttribute(new Float32Array(x.flatMap((value, k) => [value, y[k], 0])), 3);
    const shape = (index) => new BufferGeometry().setAttribute("position", places).setIndex(index);
    this.put(new Mesh(shape(faces), plane("--water", 0.22))).renderOrder = -1;
    this.put(new LineSegments(shape(rows), edge("--water-edge", 0.3)));
    this.put(new LineSegments(shape(border), edge("--water-edge")));
    this.water = { x, y, places };
    this.flow();
  }

  // bring the waves to the time of the sea
  flow() {
    const now = `${this.sea?.run}/${this.sea?.time}`;
    if (!this.water || this.water.now === now) return; // a camera that turns moves no water
    this.water.now = now;
    const { x, y, places } = this.water, z = this.sea.heights(x, y);
    z.forEach((height, k) => places.setZ(k, height * this.rise));
    places.needsUpdate = true;
    document.documentElement.dataset.water = [x[0], y[0], z[0]]; // a test compares it
  }

  outline(ends, ground, colour) {
    const sides = ends.slice(0, 2).flatMap((x) => ends.slice(2).map((y) => [x, y, ground.at(x)]));
    this.add([...along(ground, ends, ends[2]), ...along(ground, ends, ends[3]), ...sides], colour);
  }

  label(text, axis, value) {
    const node = el(value == null ? "span.axis-name" : "span", {}, text);
    this.labels.append(node);
    this.texts.push({ node, axis, value });
  }

  // Put the numbers where the camera sees them: along the near edges, heights at a side corner.
  place(camera, width, height) {
    const v = new Vector3();
    const seen = (x, y, z) => {
      v.set(x, y, z * this.rise).project(camera);
      return [(v.x + 1) * width / 2, (1 - v.y) * height / 2, v.z];
    };
    const { ends, floor, ground, z } = this.scale;
    const middle = [(ends[0] + ends[1]) / 2, (ends[2] + ends[3]) / 2];
    const on = (x, y) => seen(x, y, ground.at(x));
    const lower = (a, b) => (on(...a)[1] >= on(...b)[1] ? a : b);
    const edgeY = lower([middle[0], ends[2]], [middle[0], ends[3]])[1];
    const edgeX = lower([ends[0], middle[1]], [ends[1], middle[1]])[0];
    const corner = this.corners.reduce((best, at) => (on(...at)[0] < on(...best)[0] ? at : best));
    const outX = 0.035 * (edgeX > middle[0] ? 1 : -1) * (ends[1] - ends[0]);
    const outY = 0.035 * (edgeY > middle[1] ? 1 : -1) * (ends[1] - ends[0]);
    const top = z.length ? z.at(-1) : floor;
    const spots = this.texts.map(({ axis, value }) => {
      const out = value == null ? 2.6 : 1;
      if (axis === "x") return on(value ?? middle[0], edgeY + outY * out);
      if (axis === "y") return seen(edgeX + outX * out, value ?? middle[1], ground.at(edgeX));
      const [px, py, d] = seen(...corner, value ?? top);
      return value == null ? [px - 6, py - 18, d] : [px - 22, py, d];
    });
    this.hang(spots, width, height, corner, top);
  }

  // Show labels that are in view and do not cover each other, names before numbers.
  hang(spots, width, height, corner, top) {
    const taken = [];
    const order = this.texts.map((_, k) => k)
      .sort((a, b) => (this.texts[a].value != null) - (this.texts[b].value != null));
    for (const k of order) {
      const [x, y, depth] = spots[k], { node, axis } = this.texts[k];
      const half = 4 + 3.4 * node.textContent.length;
      const free = depth < 1 && x > half && x < width - half && y > 8 && y < height - 8
        && taken.every((o) => Math.abs(o.x - x) > o.half + half || Math.abs(o.y - y) > 13);
      node.style.display = free ? "" : "none";
      if (!free) continue;
      taken.push({ x, y, half });
      node.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
    }
    const to = this.ruler.geometry.attributes.position, [x, y] = corner, rise = this.rise;
    const mark = 0.012 * (this.scale.ends[1] - this.scale.ends[0]);
    to.setXYZ(0, x, y, this.scale.floor * rise);
    to.setXYZ(1, x, y, top * rise);
    this.scale.z.forEach((z, k) => {
      to.setXYZ(2 * k + 2, x, y, z * rise);
      to.setXYZ(2 * k + 3, x + mark * (x > 0 ? 1 : -1), y, z * rise);
    });
    to.needsUpdate = true;
  }
}

// so that a line is drawn after the planes, on top of them
const edge = (colour, opacity = 1) =>
  new LineBasicMaterial({ color: css(colour), transparent: true, opacity });

const plane = (colour, opacity) => new MeshBasicMaterial({
  color: css(colour), transparent: true, opacity, side: 2, depthWrite: false });

// pairs of points of a line on the ground along x
function along(ground, [x0, x1], y) {
  const points = ground.places(x0, x1).map((x) => [x, y, ground.at(x)]);
  return points.slice(1).flatMap((point, k) => [points[k], point]);
}
