// A small plot on a canvas: curves, axes with units, a cursor that can be dragged.

import { css, el } from "./dom.js";
import { tickText, ticks } from "./format.js";

const LEAST_LEFT = 50, UNIT = 20, RIGHT = 10, TOP = 8, BOTTOM = 34;

export class Plot {
  // x, y: { words, unit }; onseek(x) makes the cursor draggable
  constructor(host, label, onseek) {
    this.canvas = el("canvas.plot", { role: "img", "aria-label": label });
    this.host = host;
    host.append(this.canvas);
    this.state = null;
    new ResizeObserver(() => this.paint()).observe(host);
    if (onseek) this.draggable(onseek);
  }

  draggable(onseek) {
    this.canvas.classList.add("seek");
    const seek = (event) => {
      if (!this.map) return;
      const x = this.map.back(event.clientX - this.canvas.getBoundingClientRect().left);
      onseek(x);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.canvas.hasPointerCapture(event.pointerId)) seek(event);
    });
  }

  // state: { x: {words, unit, low, high}, y: {...}, curves: [{x, y, colour, dash}], cursor, marks }
  show(state) {
    this.state = state;
    this.paint();
  }

  paint() {
    const { state, canvas } = this;
    const width = this.host.clientWidth, height = this.host.clientHeight;
    if (!state) canvas.width = canvas.width; // nothing to show: what there was goes
    if (!state || !width || !height) return;
    const sharp = Math.min(window.devicePixelRatio || 1, 3);
    canvas.width = Math.round(width * sharp);
    canvas.height = Math.round(height * sharp);
    const pen = canvas.getContext("2d");
    pen.scale(sharp, sharp);
    pen.font = `11px ${css("--font")}`;
    const { x, y } = state;
    this.tall = ticks(y.low, y.high, Math.max(2, (height - TOP - BOTTOM) / 34));
    // room for the numbers beside the unit
    const widest = Math.max(...this.tall.at.map((at) => pen.measureText(tickText(at, this.tall.step)).width));
    const left = this.left = Math.max(LEAST_LEFT, UNIT + Math.ceil(widest) + 6);
    const across = (v) => left + ((v - x.low) / (x.high - x.low || 1)) * (width - left - RIGHT);
    const up = (v) => height - BOTTOM - ((v - y.low) / (y.high - y.low || 1)) * (height - TOP - BOTTOM);
    this.map = { across, up,
      back: (px) => x.low + ((px - left) / (width - left - RIGHT)) * (x.high - x.low) };
    this.axes(pen, width, height, across, up);
    pen.save();
    pen.beginPath();
    pen.rect(left - 4, TOP - 4, width - left - RIGHT + 8, height - TOP - BOTTOM + 8); // marks at the rim
    pen.clip();
    for (const curve of state.curves) this.curve(pen, curve, across, up);
    if (state.cursor != null) {
      pen.strokeStyle = css("--ink");
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(across(state.cursor), TOP);
      pen.lineTo(across(state.cursor), height - BOTTOM);
      pen.stroke();
      for (const { at, colour } of state.marks ?? []) {
        if (!Number.isFinite(at)) continue;
        pen.fillStyle = colour;
        pen.beginPath();
        pen.arc(across(state.cursor), up(at), 3.5, 0, 7);
        pen.fill();
      }
    }
    pen.restore();
  }

  axes(pen, width, height, across, up) {
    const { x, y } = this.state;
    pen.strokeStyle = css("--line");
    pen.fillStyle = css("--faint");
    pen.lineWidth = 1;
    const { tall, left } = this;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const at of tall.at) {
      const py = Math.round(up(at)) + 0.5;
      pen.beginPath();
      pen.moveTo(left, py);
      pen.lineTo(width - RIGHT, py);
      pen.stroke();
      pen.fillText(tickText(at, tall.step), left - 6, py);
    }
    const wide = ticks(x.low, x.high, Math.max(2, (width - left - RIGHT) / 64));
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const at of wide.at) {
      const px = Math.min(across(at), width - RIGHT - 4);
      pen.fillText(tickText(at, wide.step), px, height - BOTTOM + 5);
    }
    pen.fillText(`${x.words} (${x.unit || "-"})`, (left + width - RIGHT) / 2, height - 13);
    pen.save();
    pen.translate(9, (TOP + height - BOTTOM) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textBaseline = "middle";
    pen.fillText(y.unit || "-", 0, 0);
    pen.restore();
  }

  curve(pen, { x, y, colour, dash }, across, up) {
    pen.strokeStyle = colour;
    pen.lineWidth = 1.6;
    pen.lineJoin = "round";
    pen.setLineDash(dash ?? []);
    pen.beginPath();
    let down = false;
    for (let k = 0; k < x.length; k++) {
      if (!Number.isFinite(y[k]) || !Number.isFinite(x[k])) {
        down = false;
        continue;
      }
      if (down) pen.lineTo(across(x[k]), up(y[k]));
      else pen.moveTo(across(x[k]), up(y[k]));
      down = true;
    }
    pen.stroke();
    pen.setLineDash([]);
  }
}

// axis limits around values, with zero where it is near
export function limits(low, high) {
  if (!(low <= high)) return [0, 1];
  if (low > 0 && low < 0.4 * high) low = 0;
  if (high < 0 && high > 0.4 * low) high = 0;
  const room = 0.05 * (high - low) || 0.05 * Math.max(Math.abs(high), 1e-9);
  return [low === 0 ? 0 : low - room, high === 0 ? 0 : high + room];
}

