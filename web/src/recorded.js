// The page of a results file: the scene, its timeline, read-outs and plots that follow the cursor.

import { Clock } from "./clock.js";
import { Table } from "./data.js";
import { css, el, select } from "./dom.js";
import { shown } from "./format.js";
import { Plot, limits } from "./plot.js";
import { Scenery } from "./scenery.js";
import { Sea } from "./sea.js";
import { Shell } from "./shell.js";

const ALONG = { tension: "tension", speed: "speed" };

export function recordedPage(page, head, block) {
  return new Recorded(page, head, block);
}

class Recorded {
  constructor(page, head, block) {
    this.head = head;
    this.shell = new Shell(page, head);
    this.scenery = new Scenery(head, block, this.shell.stage);
    this.sea = head.waves && new Sea(head.waves, block);
    this.histories = head.histories.map((h) => ({ ...h, table: new Table(block, h.data),
      ends: h.extremes && new Table(block, h.extremes) }));
    const asked = new URLSearchParams(location.hash.slice(1));
    this.unknown = []; // runs asked for that are not here
    this.run = this.numbered(asked.get("run")) ?? head.first;
    this.other = this.numbered(asked.get("with"));
    this.line = this.scenery.lines[0].name;
    this.still = this.scenery.time.length < 2; // a scene at rest has no time to run through
    this.shell.transport.hidden = this.still;
    this.along = this.scenery.lines[0].tension ? "tension" : "speed";
    this.runPickers();
    this.panels();
    this.clock = new Clock(this.shell.transport, this.scenery.time, { ...head.time,
      top: head.time.factor * this.scenery.time.at(-1) }, () => this.moved());
    this.shell.stage.draw = () => this.drawScene();
    this.shell.onTheme.push(() => this.moved());
    this.box = this.scenery.box(head.runs.map((_, k) => k));
    this.pick();
    this.shell.stage.look(asked.get("view"));
    const at = Number(asked.get("t"));
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches || asked.has("t");
    this.clock.go(Number.isFinite(at) ? at : 0);
    if (!still && !this.still) this.clock.play();
  }

  // --- which run ----------------------------------------------------------------------------------

  runPickers() {
    const { head, shell } = this;
    const rows = [];
    if (head.runs.length > 1) {
      rows.push(el("label.run", {}, el("span", {}, "Run"), this.runBox()));
      rows.push(el("label.other", {}, el("span", {}, "with"), this.otherBox()));
      if (head.runs_in_file > head.runs.length) {
        rows.push(el("span.few", {}, `${head.runs.length} of ${head.runs_in_file} runs`));
      }
    }
    for (const text of this.unknown) rows.push(el("span.few.unknown", {}, `no run ${text} here`));
    const times = this.scenery.time.length;
    if (head.times_in_file > times) {
      rows.push(el("span.few", { title: "Histories keep their largest and smallest values" },
        `${times} of ${head.times_in_file} times`));
    }
    shell.pickers.replaceChildren(...rows);
  }

  // which of the runs that are here has a number of the file's, null of none
  numbered(text) {
    if (text == null || text === "") return null;
    const found = this.head.runs.findIndex((run) => String(run.number) === text);
    if (found < 0) this.unknown.push(text);
    return found < 0 ? null : found;
  }

  // one list for each swept number where they form a grid, else one list of runs
  runBox() {
    const { axes, runs } = this.head;
    const choices = axes.map((axis) => [...new Set(axis.texts)]);
    const whole = choices.reduce((product, texts) => product * texts.length, 1) === runs.length;
    if (!axes.length || !whole) {
      const box = select("Run", runs.map((run, k) => [k, run.label]), (value) => {
        this.run = Number(value);
        this.pick();
      });
      box.value = this.run;
      return box;
    }
    const boxes = axes.map((axis, a) => {
      const named = (text) => (axis.words === "case" ? text : `${axis.words} ${text}`);
      const box = select(axis.words, choices[a].map((text) => [text, named(text)]), () => {
        this.run = runs.findIndex((_, run) => axes.every((one, k) => one.texts[run] === boxes[k].value));
        this.pick();
      });
      box.value = axis.texts[this.run];
      return box;
    });
    return el("span.axes", {}, ...boxes);
  }

  otherBox() {
    const items = [["", "no other"], ...this.head.runs.map((run, k) => [k, run.label])];
    const box = select("Run laid over it", items, (value) => {
      this.other = value === "" ? null : Number(value);
      this.pick();
    });
    box.value = this.other ?? "";
    return box;
  }

  pick() {
    const run = this.head.runs[this.run];
    const around = this.head.surroundings[this.run], told = JSON.stringify(around);
    if (told !== this.around) this.shell.stage.setRoom(this.box, around, this.sea);
    this.around = told;
    this.scenery.build(this.run, this.other);
    for (const tube of this.shell.stage.tubes.values()) tube.dots.visible = this.shell.nodesBox.checked;
    this.range = this.scenery.range(this.run);
    const scale = this.scenery.lines.map((line) => line.scales.tension).find(Boolean);
    if (this.range && scale) {
      this.shell.setLegend(`tension (${scale.unit})`, ...this.range.map((v) => shown(v, scale)));
    } else this.shell.legendName.parentElement.hidden = true;
    const bad = run.status !== "ok";
    this.shell.note.textContent = bad ? `${run.status}${run.message ? `: ${run.message}` : ""}`
      : this.head.complete ? "" : "The file is incomplete.";
    this.fillNumbers();
    this.plotHistory();
    if (this.clock) this.moved();
  }

  // --- the side -----------------------------------------------------------------------------------

  panels() {
    const { lines } = this.scenery;
    const linePicker = lines.length > 1 && select("Line", lines.map((line) => [line.name, line.name]),
      (value) => {
        this.line = value;
        this.fillReadouts();
        this.plotHistory();
        this.moved();
      });
    this.readouts = el("tbody");
    this.numbers = el("tbody");
    this.energies = el("tbody");
    this.alongHost = el("div.plothost");
    this.historyHost = el("div.plothost");
    const alongItems = Object.entries(ALONG).filter(([key]) => lines.some((line) => line[key]))
      .map(([key, words]) => [key, `${words} along the line`]);
    this.alongBox = select("Quantity along the line", alongItems, (value) => {
      this.along = value;
      this.moved();
    });
    this.historyBox = this.historyPicker();
    this.key = el("span.key");
    const values = (body, kind) => el(`table.values.${kind}`, {}, body);
    this.shell.side.replaceChildren(
      el("section.readouts", { "aria-label": "Values now" },
        linePicker && el("label.pick", {}, "Line ", linePicker), values(this.readouts, "now")),
      el("section.figure", {}, el("div.plothead", {}, this.alongBox), this.alongHost),
      el("section.figure", { hidden: this.still }, el("div.plothead", {}, this.historyBox, this.key), this.historyHost),
      this.head.outputs.length > 0 && el("details.more", { open: true }, el("summary", {}, "Numbers of the run"), values(this.numbers, "run")),
      this.histories.some((h) => h.group === "energy")
        && el("details.more", {}, el("summary", {}, "Energies now"), values(this.energies, "now")));
    this.alongPlot = new Plot(this.alongHost, "Quantity along the line at this time");
    this.historyPlot = new Plot(this.historyHost, "History of a quantity", (time) => {
      this.clock.pause();
      this.clock.go(time / this.head.time.factor);
    });
    this.fillReadouts();
  }

  historyPicker() {
    const groups = new Map();
    for (const { key, group, words } of this.histories) {
      if (!groups.has(group)) groups.set(group, []);
      groups.get(group).push(el("option", { value: key }, words));
    }
    for (const { name } of this.scenery.lines) {
      const ends = ["start", "end"].map((side) => `lines/${name}/${side}_tension`);
      if (ends.every((end) => this.histories.some((h) => h.key === end))) {
        groups.get(name).unshift(el("option", { value: ends.join(" ") }, "tension at both ends"));
      }
    }
    const box = el("select", { "aria-label": "History" }, ...[...groups].map(([name, options]) =>
      el("optgroup", { label: name || "scene" }, ...options)));
    box.addEventListener("change", () => {
      this.plotHistory();
      this.moved();
    });
    return box;
  }

  fillReadouts() {
    this.cells = [];
    const { lines } = this.scenery;
    const row = (h) => {
      const cells = [el("td.value", { "data-key": h.key }), el("td.value.second", { "data-key": `${h.key}+` })];
      this.cells.push([h, cells]);
      return el("tr", {}, el("th", { scope: "row" }, h.words), cells[0], cells[1], el("td.unit", {}, h.unit));
    };
    const isLine = (h) => lines.some((line) => line.name === h.group);
    const own = this.histories.filter((h) => h.group === this.line);
    const rest = this.histories.filter((h) => !isLine(h) && h.group !== "energy");
    this.readouts.replaceChildren(...own.map(row), ...rest.map(row));
    this.energies.replaceChildren(...this.histories.filter((h) => h.group === "energy").map(row));
  }

  fillNumbers() {
    const rows = [];
    let end = "";
    for (const output of this.head.outputs) { // those of ends first
      if (output.end !== end) rows.push(el("tr", {}, el("th.end", { colspan: 3 }, output.end || "whole run")));
      end = output.end;
      rows.push(el("tr", { title: output.key }, el("th", { scope: "row" }, output.words),
        el("td.value", { "data-key": output.key }, output.texts[this.run]),
        el("td.value.second", {}, this.other == null ? "" : output.texts[this.other])));
    }
    this.numbers.replaceChildren(...rows);
  }

  // --- following the cursor -----------------------------------------------------------------------

  moved() {
    const at = this.clock.sample;
    for (const [h, cells] of this.cells) {
      cells[0].textContent = shown(h.table.at(this.run, at), h);
      cells[1].textContent = this.other == null ? "" : shown(h.table.at(this.other, at), h);
    }
    this.plotAlong();
    if (this.historyPlot.state) {
      const { state } = this.historyPlot;
      state.cursor = this.clock.now * this.head.time.factor;
      state.marks = state.tables.map(({ h, run, colour }) => ({ at: h.table.at(run, at) * h.factor, colour }));
      this.historyPlot.paint();
    }
    this.shell.stage.dirty();
  }

  drawScene() {
    this.sea?.show(this.run, this.clock.now);
    this.shell.stage.frame.flow();
    this.scenery.draw("main", this.run, this.clock.now, this.range);
    if (this.other != null) this.scenery.draw("other", this.other, this.clock.now, null);
  }

  shownRuns() {
    const runs = [[this.run, css("--first")]];
    if (this.other != null) runs.push([this.other, css("--second")]);
    return runs.reverse(); // the chosen run on top
  }

  plotAlong() {
    const line = this.scenery.lines.find((one) => one.name === this.line);
    const table = line[this.along];
    if (!table) return this.alongPlot.show(null);
    const scale = line.scales[this.along];
    const place = this.along === "tension" ? line.middle : line.place;
    const frame = this.scenery.frameAt(this.clock.now).nearest;
    let low = Infinity, high = -Infinity, far = 0;
    const curves = this.shownRuns().map(([run, colour]) => {
      const [a, b] = table.range(run);
      low = Math.min(low, a * scale.factor);
      high = Math.max(high, b * scale.factor);
      const nodes = line.place.row(run).filter(Number.isFinite);
      far = Math.max(far, nodes.at(-1));
      let x = place.row(run), y = table.row(run, frame).map((v) => v * scale.factor);
      // a segment has one tension from node to node: the first and the last reach to the ends
      if (place === line.middle) {
        if (nodes.length === 2) [x, y] = [[x[0], x[0]], [y[0], y[0]]];
        x[0] = nodes[0];
        x[x.findLastIndex(Number.isFinite)] = nodes.at(-1);
      }
      return { x, y, colour };
    });
    [low, high] = limits(low, high);
    const words = `distance along the line, unstretched${line.paid ? " at the start" : ""}`;
    this.alongPlot.show({ x: { words, unit: "m", low: 0, high: far },
      y: { unit: scale.unit, low, high }, curves });
  }

  plotHistory() {
    const keys = this.historyBox.value.split(" ");
    const picked = keys.map((key) => this.histories.find((h) => h.key === key));
    const { factor, unit } = this.head.time;
    let low = Infinity, high = -Infinity;
    const tables = [];
    for (const [run, colour] of this.shownRuns()) for (const h of picked) tables.push({ h, run, colour });
    const curves = tables.map(({ h, run, colour }) => {
      const points = this.history(h, run);
      for (const [, value] of points) {
        if (value * h.factor < low) low = value * h.factor;
        if (value * h.factor > high) high = value * h.factor;
      }
      const dash = picked.length > 1 && h === picked[0] ? [2, 3] : null;
      return { x: points.map(([t]) => t * factor), y: points.map(([, v]) => v * h.factor), colour, dash };
    });
    [low, high] = limits(low, high);
    this.key.textContent = picked.length > 1 ? "start dotted, end solid" : "";
    const time = this.scenery.time;
    this.historyPlot.show({ x: { words: "time", unit, low: time[0] * factor, high: time.at(-1) * factor },
      y: { unit: picked[0].unit, low, high }, curves, tables,
      cursor: this.clock ? this.clock.now * factor : time[0] * factor });
  }

  // [time, value] of a history at the times of the page, and at its extremes where those are between
  history(h, run) {
    const points = Array.from(h.table.row(run), (value, k) => [this.scenery.time[k], value]);
    for (const k of h.ends ? [0, 1] : []) {
      const [time, value] = [0, 1].map((what) => h.ends.at(run, k, what));
      const after = points.findIndex(([t]) => t >= time);
      if (after >= 0 && points[after][0] !== time) points.splice(after, 0, [time, value]);
    }
    return points;
  }
}
