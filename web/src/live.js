// The live page: sliders, and a shape at rest that follows them.

import { css, el, select } from "./dom.js";
import { shown } from "./format.js";
import { colour, shades } from "./palette.js";
import { Plot, limits } from "./plot.js";
import { rgbOf } from "./scenery.js";
import { Shell, isDark } from "./shell.js";

export function livePage(page, head) {
  return new Live(page, head);
}

class Live {
  constructor(page, head) {
    this.head = head;
    this.shell = new Shell(page, head);
    this.models = new Map(head.models.map((model) => [model.key, model]));
    this.values = new Map(head.models.map((model) =>
      [model.key, Object.fromEntries(model.controls.map((c) => [c.key, c.value]))]));
    this.pickers();
    this.panels();
    this.shell.stage.draw = () => this.drawScene();
    this.shell.onTheme.push(() => this.answer && this.show());
    this.open(head.first);
  }

  pickers() {
    const save = el("button", { type: "button", onclick: () => this.save() }, "Save as TOML");
    const reset = el("button", { type: "button", onclick: () => this.reset() }, "Reset");
    const items = this.head.models.map((model) => [model.key, model.words]);
    this.stageBox = select("Stage", items, (key) => this.open(key));
    this.shell.pickers.replaceChildren(
      items.length > 1 ? el("label.run", {}, el("span", {}, "Stage"), this.stageBox) : "", reset, save);
  }

  panels() {
    this.controls = el("section.controls", { "aria-label": "Numbers" });
    this.numbers = el("tbody");
    this.equations = el("div.equations");
    this.equationBox = el("section", {}, el("h2", {}, "Shape, x and z in m"), this.equations);
    this.plotHost = el("div.plothost");
    this.secondKey = el("p.key.second", {}, "orange: straight segments, without the line's weight");
    this.remark = el("p.key.remark");
    this.shell.side.replaceChildren(
      el("section.readouts", { "aria-label": "Values" }, el("table.values.now", {}, this.numbers), this.remark,
        this.secondKey),
      this.controls,
      this.equationBox,
      el("section.figure", {}, el("h2", {}, "Tension along the line"), this.plotHost));
    this.plot = new Plot(this.plotHost, "Tension along the line");
  }

  // --- sliders ------------------------------------------------------------------------------------

  open(key) {
    this.model = this.models.get(key);
    this.stageBox.value = key;
    this.box = null;
    // those of another stage would mislead while this one is worked out
    this.numbers.replaceChildren();
    this.secondKey.hidden = this.equationBox.hidden = true;
    this.remark.textContent = this.model.remark;
    this.remark.hidden = !this.model.remark;
    this.buildControls();
    this.ask();
  }

  buildControls() {
    const groups = new Map();
    for (const control of this.model.controls) {
      if (!groups.has(control.group)) groups.set(control.group, []);
      groups.get(control.group).push(this.control(control));
    }
    const many = groups.size > 1;
    this.controls.replaceChildren(...[...groups].map(([group, rows]) => (many
      ? el("details.group", { open: group.startsWith("lines") || group === "" },
        el("summary", {}, group || "scene"), ...rows)
      : el("div.group", {}, ...rows))));
  }

  control(control) {
    const values = this.values.get(this.model.key);
    const inUnit = (value) => value * control.factor;
    const span = inUnit(control.high - control.low);
    const slider = el("input.slide", { type: "range", "aria-label": control.words, "data-key": control.key,
      min: inUnit(control.low), max: inUnit(control.high), step: span / 1000 || "any" });
    const field = el("input.field", { type: "number", step: "any", "aria-label": `${control.words}, typed` });
    const show = (value) => {
      slider.value = inUnit(value);
      field.value = Number(inUnit(value).toPrecision(6));
    };
    const change = (input, other) => () => {
      const value = Number(input.value);
      if (input.value === "" || !Number.isFinite(value)) return;
      other.value = input === slider ? Number(value.toPrecision(6)) : value;
      values[control.key] = value / control.factor;
      this.ask();
    };
    slider.addEventListener("input", change(slider, field));
    field.addEventListener("input", change(field, slider));
    show(values[control.key]);
    return el("div.control", {}, el("label", {}, control.words), field,
      el("span.unit", {}, control.unit), slider);
  }

  reset() {
    this.values.set(this.model.key, Object.fromEntries(this.model.controls.map((c) => [c.key, c.value])));
    this.open(this.model.key);
  }

  // --- asking: one question at a time, always the latest --------------------------------------------

  async ask() {
    if (this.asking) {
      this.again = true;
      if (this.asked !== this.model) this.pending.abort(); // nobody waits for it any more
      return;
    }
    this.asking = true;
    document.documentElement.dataset.asking = "yes"; // a test waits for "no"
    try {
      do {
        this.again = false;
        const model = this.asked = this.model, begun = performance.now();
        this.pending = new AbortController();
        const patience = setTimeout(() => this.say("Working: the first shape takes some seconds to prepare."), 900);
        const reply = await this.post("solve", this.pending.signal)
          .catch((error) => { if (error.name !== "AbortError") throw error; })
          .finally(() => clearTimeout(patience));
        if (model !== this.model || !reply) this.again = true;
        else this.take(reply, performance.now() - begun);
      } while (this.again);
    } catch (error) {
      this.say(`The program behind this page does not answer (${error.message}); start it again.`);
    } finally {
      this.asking = false;
      document.documentElement.dataset.asking = "no";
    }
  }

  async post(what, signal) {
    const changed = Object.fromEntries(this.model.controls
      .map((c) => [c.key, this.values.get(this.model.key)[c.key]])
      .filter(([key, value]) => value !== this.model.controls.find((c) => c.key === key).value));
    const answer = await fetch(what, { method: "POST", signal, headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ model: this.model.key, values: changed }) });
    return answer.json();
  }

  async save() {
    const reply = await this.post("toml");
    if (reply.fault) return this.say(reply.fault);
    const link = el("a", { download: reply.name, href: URL.createObjectURL(new Blob([reply.text])) });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  say(text) {
    this.shell.note.textContent = text;
    document.documentElement.dataset.fault = text ? "yes" : "no";
  }

  // --- the answer ---------------------------------------------------------------------------------

  take(reply, milliseconds) {
    this.say(reply.fault ?? "");
    document.documentElement.dataset.took = milliseconds.toFixed(1);
    if (reply.fault) return;
    this.answer = reply;
    this.rebuild();
    this.show();
    document.documentElement.dataset.answers = Number(document.documentElement.dataset.answers ?? 0) + 1;
  }

  // new tubes and boxes where they differ by more than their places, a new room where they do not fit the old one
  rebuild() {
    const { lines, points } = this.answer, { stage } = this.shell;
    const form = JSON.stringify([this.model.key, lines.map((l) => [l.position.length, l.diameter, l.second]),
      points.map((p) => [p.name, p.size, p.points])]);
    if (form !== this.form) {
      this.form = form;
      stage.clear();
      lines.forEach((line, k) => {
        const tube = stage.tube(`line ${k}`, line.position.length, line.diameter / 2, line.second ? 1.4 : 2.6);
        tube.dots.visible = this.shell.nodesBox.checked && !line.second;
      });
      points.forEach((point, k) => stage.solid(`point ${k}`, point.size, point.points));
    }
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const line of lines) for (const at of line.position) for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k], at[k]);
      high[k] = Math.max(high[k], at[k]);
    }
    for (const point of points) for (let k = 0; k < 3; k++) {
      const half = Math.max((point.size?.[k] ?? 0) / 2, ...(point.points ?? []).map((at) => Math.abs(at[k])));
      low[k] = Math.min(low[k], point.at[k] - half);
      high[k] = Math.max(high[k], point.at[k] + half);
    }
    const size = Math.max(...high.map((v, k) => v - low[k]));
    const around = this.answer.surroundings ?? this.head.surroundings, told = JSON.stringify(around);
    const fits = this.box && told === this.around && low.every((v, k) => v >= this.box.low[k] && high[k] <= this.box.high[k])
      && size > 0.45 * Math.max(...this.box.high.map((v, k) => v - this.box.low[k]));
    if (fits) return;
    this.around = told;
    const room = this.box ? 0.15 * size : 0.04 * size;
    this.box = { low: low.map((v) => v - room), high: high.map((v) => v + room) };
    stage.setRoom(this.box, around);
    const solid = points.some((point) => point.size), across = high[1] - low[1] > high[0] - low[0];
    stage.look(stage.view ?? (solid ? "corner" : across ? "front" : "side"));
  }

  show() {
    const { lines, numbers, equations } = this.answer;
    const tensions = lines.filter((line) => !line.second)
      .flatMap((line) => [...line.tension, ...line.ends]);
    if (!tensions.length) return this.say("This scene has no line to draw at rest.");
    this.range = shades(Math.min(...tensions), Math.max(...tensions));
    const [low, high] = this.range;
    const scale = { factor: 1e-3, top: high * 1e-3 };
    this.shell.setLegend("tension (kN)", shown(low, scale), shown(high, scale));
    const second = numbers.some((row) => row.second != null);
    this.secondKey.hidden = !second;
    const many = new Set(numbers.map((row) => row.group)).size > 1, rows = [];
    let group = null;
    for (const row of numbers) {
      if (many && row.group !== group) rows.push(el("tr", {}, el("th.end", { colspan: 3 }, row.group)));
      group = row.group;
      rows.push(el("tr", {}, el("th", { scope: "row" }, row.words),
        el("td.value", { "data-key": row.key, "data-si": row.value }, shown(row.value, row)),
        second && el("td.value.second", {}, row.second == null ? "" : shown(row.second, row)),
        el("td.unit", {}, row.unit)));
    }
    this.numbers.replaceChildren(...rows);
    this.equationBox.hidden = equations.length === 0;
    this.equations.replaceChildren(...equations.map((text) => el("code", {}, text)));
    this.plotTension(scale);
    this.shell.stage.dirty();
  }

  plotTension(scale) {
    let start = 0, low = Infinity, high = -Infinity;
    const curves = [];
    for (const line of this.answer.lines) {
      if (line.second) continue;
      const y = [line.ends[0], ...line.tension, line.ends[1]].map((v) => v * scale.factor);
      low = Math.min(low, ...y);
      high = Math.max(high, ...y);
      const x = line.place.map((s) => s + start);
      const first = start;
      start += line.length; // lines one after another
      curves.push({ x: [first, ...x, start], y, colour: css("--first") });
    }
    [low, high] = limits(low, high);
    this.plot.show({ x: { words: "distance along the line", unit: "m", low: 0, high: start },
      y: { unit: "kN", low, high }, curves });
  }

  drawScene() {
    if (!this.answer) return;
    const { stage } = this.shell, dark = isDark(), [low, high] = this.range;
    this.answer.lines.forEach((line, k) => {
      const count = line.position.length;
      const points = new Float64Array(3 * count), rgb = new Float32Array(3 * count);
      const flat = line.second ? rgbOf(css("--second")) : null;
      line.position.forEach(([x, y, z], i) => {
        points.set([x, y, z * stage.rise], 3 * i);
        if (flat) return rgb.set(flat, 3 * i);
        const t = i === 0 ? line.ends[0] : i === count - 1 ? line.ends[1]
          : (line.tension[i - 1] + line.tension[i]) / 2;
        colour((t - low) / (high - low || 1), dark, rgb, 3 * i);
      });
      stage.tubes.get(`line ${k}`)?.update(points, rgb, stage.camera, (x, y, z) => stage.pixelAt(x, y, z));
    });
    this.answer.points.forEach((point, k) => stage.place(`point ${k}`, point.at, point.turn));
  }
}
