// What both pages share: the heading, the stage with its buttons and legend, the colour theme.

import { el, select } from "./dom.js";
import { gradient } from "./palette.js";
import { Stage } from "./stage.js";

const THEMES = [["auto", "Auto"], ["light", "Light"], ["dark", "Dark"]];

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen === "dark" || (chosen !== "light" && matchMedia("(prefers-color-scheme: dark)").matches);
}

export class Shell {
  constructor(page, head) {
    this.onTheme = [];
    this.host = el("div.stage");
    this.pickers = el("div.pickers");
    this.side = el("div.side");
    this.transport = el("div.transport");
    this.note = el("p.note", { role: "status" });
    page.className = `page ${head.kind}`;
    page.replaceChildren(
      el("header", {}, el("div.heading", {}, el("h1", {}, head.title),
        el("p.file", {}, head.file ?? "")), this.pickers, this.themePicker()),
      el("section.scene", { "aria-label": "Scene" }, this.host, this.tools(), this.legend(), this.note),
      this.side, this.transport);
    this.stage = new Stage(this.host);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.retheme());
  }

  themePicker() {
    const stored = readTheme();
    document.documentElement.dataset.theme = stored;
    const box = select("Colours", THEMES, (value) => {
      document.documentElement.dataset.theme = value;
      writeTheme(value);
      this.retheme();
    }, { class: "theme" });
    box.value = stored;
    return box;
  }

  retheme() {
    this.paintLegend();
    this.stage.theme();
    for (const react of this.onTheme) react();
  }

  tools() {
    const button = (view, text) => el("button", { type: "button", title: `View: ${view}`,
      onclick: () => this.stage.look(view) }, text);
    this.nodesBox = el("input", { type: "checkbox", onchange: () => {
      for (const tube of this.stage.tubes.values()) tube.dots.visible = this.nodesBox.checked;
      this.stage.dirty();
    } });
    const rise = select("Heights drawn larger by", [1, 2, 5, 10, 20].map((k) => [k, `z ×${k}`]),
      (value) => this.stage.setRise(Number(value)), { title: "Draw heights larger" });
    return el("div.tools", {}, el("div.views", { role: "group", "aria-label": "Camera" },
      button("corner", "3-D"), button("side", "Side"), button("front", "Front"), button("top", "Top")),
      rise, el("label", {}, this.nodesBox, "Nodes"));
  }

  legend() {
    this.bar = el("div.bar");
    this.low = el("span");
    this.high = el("span");
    this.legendName = el("span.name", {}, "tension");
    return el("div.legend", {}, this.legendName, this.bar, el("div.ends", {}, this.low, this.high));
  }

  setLegend(name, low, high) {
    this.legendName.textContent = name;
    this.low.textContent = low;
    this.high.textContent = high;
    this.paintLegend();
  }

  paintLegend() {
    this.bar.style.background = gradient(isDark());
  }
}

// a saved page may be opened where nothing can be stored
function readTheme() {
  try {
    return localStorage.getItem("lumpedcable-theme") ?? "auto";
  } catch {
    return "auto";
  }
}

function writeTheme(value) {
  try {
    localStorage.setItem("lumpedcable-theme", value);
  } catch { /* then it holds for this visit */ }
}
