// A line as a tube: rings around its nodes, carried along without twist. It has its true radius, but
// never less than a few pixels.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Mesh, MeshBasicMaterial,
  Points, PointsMaterial } from "three";

const SIDES = 8;

export class Tube {
  // behind: drawn first and under everything, so that it frames a line that lies on it
  constructor(nodes, radius, pixels, behind = false) {
    this.radius = radius;
    this.pixels = pixels;
    this.geometry = new BufferGeometry();
    this.vertices = new Float32Array(nodes * SIDES * 3);
    this.colours = new Float32Array(nodes * SIDES * 3);
    const index = [];
    for (let i = 0; i + 1 < nodes; i++) {
      for (let k = 0; k < SIDES; k++) {
        const a = i * SIDES + k, b = i * SIDES + ((k + 1) % SIDES);
        index.push(a, b, a + SIDES, b, b + SIDES, a + SIDES);
      }
    }
    for (const [name, array] of [["position", this.vertices], ["color", this.colours]]) {
      this.geometry.setAttribute(name, new BufferAttribute(array, 3).setUsage(DynamicDrawUsage));
    }
    this.geometry.setIndex(index);
    this.mesh = new Mesh(this.geometry, new MeshBasicMaterial({ vertexColors: true, side: 2 }));
    this.mesh.frustumCulled = false;
    if (behind) {
      this.mesh.renderOrder = -0.5;
      this.mesh.material.depthWrite = false;
    }
    this.dots = new Points(new BufferGeometry(),
      new PointsMaterial({ size: 5, sizeAttenuation: false }));
    this.centres = new Float32Array(nodes * 3);
    this.dots.geometry.setAttribute("position",
      new BufferAttribute(this.centres, 3).setUsage(DynamicDrawUsage));
    this.dots.frustumCulled = false;
    this.dots.visible = false;
  }

  // points and rgb: three numbers a node; NaN from the first lost node on ends the tube there
  update(points, rgb, camera, pixelAt) {
    const count = this.centres.length / 3;
    let used = 0;
    while (used < count && Number.isFinite(points[3 * used] + points[3 * used + 2])) used++;
    this.mesh.visible = used > 1;
    this.geometry.setDrawRange(0, Math.max(used - 1, 0) * SIDES * 6);
    this.dots.geometry.setDrawRange(0, used);
    if (used < 2) return;
    const t = [0, 0, 0], side = [0, 0, 0], up = [0, 0, 0];
    const { x: cx, y: cy, z: cz } = camera.position;
    for (let i = 0; i < used; i++) {
      const a = 3 * Math.max(i - 1, 0), b = 3 * Math.min(i + 1, used - 1), o = 3 * i;
      for (let k = 0; k < 3; k++) t[k] = points[b + k] - points[a + k];
      unit(t, [1, 0, 0]);
      // the last ring's side, made square to this tangent
      if (i === 0) {
        const least = Math.abs(t[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
        for (let k = 0; k < 3; k++) side[k] = least[k];
      }
      const along = side[0] * t[0] + side[1] * t[1] + side[2] * t[2];
      for (let k = 0; k < 3; k++) side[k] -= along * t[k];
      unit(side, Math.abs(t[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]);
      cross(t, side, up);
      const [px, py, pz] = [points[o], points[o + 1], points[o + 2]];
      this.centres.set([px, py, pz], o);
      const radius = Math.max(this.radius, this.pixels * pixelAt(px, py, pz));
      const view = [cx - px, cy - py, cz - pz];
      unit(view, [0, 0, 1]);
      for (let k = 0; k < SIDES; k++) {
        const angle = (2 * Math.PI * k) / SIDES, c = Math.cos(angle), s = Math.sin(angle);
        const v = 3 * (i * SIDES + k);
        let facing = 0;
        for (let j = 0; j < 3; j++) {
          const normal = c * side[j] + s * up[j];
          this.vertices[v + j] = points[o + j] + radius * normal;
          facing += normal * view[j];
        }
        // a little darker at the rim looks round and leaves the colour readable
        const shade = 0.74 + 0.26 * Math.max(facing, 0);
        for (let j = 0; j < 3; j++) this.colours[v + j] = shade * rgb[o + j];
      }
    }
    for (const name of ["position", "color"]) this.geometry.attributes[name].needsUpdate = true;
    this.dots.geometry.attributes.position.needsUpdate = true;
  }
}

function unit(v, otherwise) {
  const size = Math.hypot(v[0], v[1], v[2]);
  for (let k = 0; k < 3; k++) v[k] = size > 1e-12 ? v[k] / size : otherwise[k];
}

function cross(a, b, out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}
