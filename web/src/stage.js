// The picture: camera, lines, bodies, room. Draws when something changed, not all the time.

import { BoxGeometry, BufferAttribute, BufferGeometry, Color, ColorManagement, Group, LinearSRGBColorSpace, Mesh, MeshBasicMaterial,
  PerspectiveCamera, Quaternion, Scene, SphereGeometry, Vector3, WebGLRenderer,
  EdgesGeometry, LineSegments, LineBasicMaterial } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Bed } from "./bed.js";
import { css, el } from "./dom.js";
import { Frame } from "./frame.js";
import { Tube } from "./tube.js";

ColorManagement.enabled = false; // colours are those of the legend, to the last bit

const VIEWS = { side: [0, -1, 0.0001], front: [-1, 0, 0.0001], top: [0, -0.0001, 1],
  corner: [-0.42, -1, 0.36] };

export class Stage {
  constructor(host) {
    this.host = host;
    this.scene = new Scene();
    this.room = new Group();
    this.content = new Group();
    this.scene.add(this.room, this.content);
    this.camera = new PerspectiveCamera(30, 1, 0.1, 1e5);
    this.camera.up.set(0, 0, 1);
    this.slow = drawnByProcessor();
    this.renderer = new WebGLRenderer({ antialias: !this.slow, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.labels = el("div.labels", { "aria-hidden": "true" });
    this.renderer.domElement.setAttribute("aria-label", "The scene in three dimensions");
    host.append(this.renderer.domElement, this.labels);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.dirty());
    this.tubes = new Map();
    this.solids = new Map();
    this.draw = () => {};
    this.rise = 1;
    new ResizeObserver(() => this.resize()).observe(host);
    this.theme();
  }

  // --- what there is ------------------------------------------------------------------------------

  setRoom(box, surroundings, sea) {
    this.box = padded(box, surroundings);
    this.wet = surroundings.water && surroundings.surface == null; // water all around
    this.scene.background = new Color(css(this.wet ? "--sea" : "--stage"));
    this.frame?.empty(); // what it made is known to it alone
    this.frame = new Frame(this.room, this.labels, this.box, surroundings, sea);
    this.frame.rise = this.rise;
    this.frame.build();
    // tests look at these
    Object.assign(document.documentElement.dataset, { room: this.room.children.length,
      box: [...this.box.low, ...this.box.high] });
  }

  tube(key, nodes, radius, pixels, behind) {
    const made = new Tube(nodes, radius, pixels, behind);
    this.tubes.set(key, made);
    this.content.add(made.mesh, made.dots);
    made.dots.material.color.set(css("--ink"));
    return made;
  }

  // a ball of so many pixels, or a box of its size in metres; a post to each of its points
  solid(key, size, points = [], ink = "--body-edge", pixels = 7) {
    const shape = size ? new BoxGeometry(...size) : new SphereGeometry(1, 20, 14);
    const body = new Mesh(shape, new MeshBasicMaterial({ color: css(size ? "--body" : ink),
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    const edges = size && new LineSegments(new EdgesGeometry(shape),
      new LineBasicMaterial({ color: css(ink) }));
    if (edges) body.add(edges);
    const whole = new Group(), turned = new Group();
    whole.add(turned);
    (size ? turned : this.content).add(body); // a ball stays round where heights are drawn larger
    const ends = points.flatMap((at) => [...at.map((v, k) => within(v, (size?.[k] ?? 0) / 2)), ...at]);
    const posts = ends.length && new LineSegments(new BufferGeometry().setAttribute("position",
      new BufferAttribute(new Float32Array(ends), 3)), new LineBasicMaterial({ color: css(ink) }));
    if (posts) turned.add(posts);
    this.content.add(whole);
    this.solids.set(key, { whole, turned, body, edges, posts, ink, pixels: size ? 0 : pixels });
    return body;
  }

  clear() {
    this.content.clear();
    this.tubes.clear();
    this.solids.clear();
  }

  place(key, at, attitude) {
    const { whole, turned, body, pixels } = this.solids.get(key);
    whole.visible = body.visible = at.every(Number.isFinite);
    whole.position.set(at[0], at[1], at[2] * this.rise);
    whole.scale.set(1, 1, this.rise);
    if (attitude) turned.quaternion.copy(new Quaternion(attitude[1], attitude[2], attitude[3], attitude[0]));
    if (pixels) {
      body.position.copy(whole.position);
      body.scale.setScalar(pixels * this.pixelAt(...whole.position));
    }
  }

  setRise(rise) {
    this.rise = rise;
    this.frame.rise = rise;
    this.frame.build();
    this.look(this.view);
  }

  // --- camera -------------------------------------------------------------------------------------

  // an address can ask for any view: one that there is not is the corner
  look(asked) {
    const view = Object.hasOwn(VIEWS, asked) ? asked : "corner";
    this.view = view;
    const { low, high } = this.box;
    const middle = new Vector3(...low.map((a, k) => ((a + high[k]) / 2) * (k === 2 ? this.rise : 1)));
    const way = new Vector3(...VIEWS[view]).normalize();
    this.camera.position.copy(middle).addScaledVector(way, 1);
    this.camera.lookAt(middle);
    this.camera.updateMatrixWorld();
    // far enough back that every corner is inside, with room for labels
    const out = Math.tan((this.camera.fov * Math.PI) / 360);
    const inverse = this.camera.matrixWorldInverse.copy(this.camera.matrixWorld).invert();
    let distance = 0;
    // labels stand some 50 pixels beside
    const room = { x: Math.min(0.86, 1 - 104 / Math.max(this.host.clientWidth, 208)), y: 0.7 };
    for (const x of [low[0], high[0]]) for (const y of [low[1], high[1]]) for (const z of [low[2], high[2]]) {
      const p = new Vector3(x, y, z * this.rise).applyMatrix4(inverse);
      const depth = p.z + 1;
      distance = Math.max(distance, depth + Math.abs(p.x) / (out * this.camera.aspect * room.x),
        depth + Math.abs(p.y) / (out * room.y));
    }
    this.camera.position.copy(middle).addScaledVector(way, distance);
    this.camera.near = distance / 200;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(middle);
    this.controls.update();
    this.dirty();
  }

  // metres that one pixel spans at a place
  pixelAt(x, y, z) {
    const e = this.camera.matrixWorldInverse.elements;
    const depth = -(e[2] * x + e[6] * y + e[10] * z + e[14]);
    const height = this.renderer.domElement.clientHeight || 1;
    return (2 * Math.tan((this.camera.fov * Math.PI) / 360) * Math.max(depth, this.camera.near)) / height;
  }

  // --- drawing ------------------------------------------------------------------------------------

  dirty() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.sharpness(1);
      this.render();
      if (this.slow) this.refineSoon();
    });
  }

  // a picture drawn by the processor has its edges smoothed once it stands still
  refineSoon() {
    clearTimeout(this.still);
    this.still = setTimeout(() => {
      this.sharpness(2);
      this.render();
    }, 400);
  }

  // pixels drawn for each pixel shown, along each axis
  sharpness(factor) {
    const ratio = Math.min(window.devicePixelRatio * factor, 2);
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
  }

  render() {
    if (!this.frame || !this.host.clientWidth) return;
    this.camera.updateMatrixWorld();
    this.draw();
    this.frame.place(this.camera, this.host.clientWidth, this.host.clientHeight);
    this.renderer.render(this.scene, this.camera);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    const before = this.camera.aspect;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.renderer.setSize(width, height);
    if (this.view && Math.abs(before - this.camera.aspect) > 0.05 * before) this.look(this.view);
    this.dirty();
  }

  theme() {
    this.scene.background = new Color(css(this.wet ? "--sea" : "--stage"));
    for (const tube of this.tubes.values()) tube.dots.material.color.set(css("--ink"));
    for (const { body, edges, posts, ink } of this.solids.values()) {
      body.material.color.set(css(edges ? "--body" : ink));
      for (const lines of [edges, posts]) if (lines) lines.material.color.set(css(ink));
    }
    this.frame?.build();
    this.dirty();
  }
}

// without a graphics card smooth edges cost half of the time that a slider takes
function drawnByProcessor() {
  const probe = document.createElement("canvas").getContext("webgl2");
  const names = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? probe.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

const within = (value, half) => Math.min(Math.max(value, -half), half);

// A flat scene still needs a room to stand in, and a bed or surface nearby belongs to it.
function padded({ low, high }, { bed, surface }) {
  low = [...low];
  high = [...high];
  if (bed != null) low[2] = Math.min(low[2], new Bed(bed).range(low[0], high[0])[0]);
  const wide = Math.max(...high.map((value, k) => value - low[k]), 1e-3);
  if (surface != null && surface < high[2] + 0.5 * wide) high[2] = Math.max(high[2], surface);
  for (let k = 0; k < 3; k++) {
    const least = (k === 2 ? 0.08 : 0.16) * wide, lack = least - (high[k] - low[k]);
    if (lack > 0) {
      low[k] -= lack / 2;
      high[k] += lack / 2;
    }
  }
  if (bed != null) {
    const [lowest, highest] = new Bed(bed).range(low[0], high[0]);
    low[2] = lowest;
    high[2] = Math.max(high[2], highest);
  }
  return { low, high };
}
