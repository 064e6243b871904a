// Playing: simulated time against the wall clock, in 1-2-5 steps of slow and fast motion.

import { el } from "./dom.js";
import { shown } from "./format.js";

const SECONDS = 9; // a run should take about so long to watch

export class Clock {
  // times: saved times in s; onchange() after every move of the cursor
  constructor(host, times, scale, onchange) {
    Object.assign(this, { times, scale, onchange });
    this.last = times.at(-1);
    this.now = times[0];
    this.rate = nice((this.last - times[0] || 1) / SECONDS);
    this.playing = false;
    this.button = el("button.play", { type: "button", onclick: () => this.toggle() });
    this.track = el("input.track", { type: "range", min: 0, max: times.length - 1, step: 1, value: 0,
      "aria-label": "Time", oninput: () => {
        this.pause();
        this.go(this.times[Number(this.track.value)]);
      } });
    this.readout = el("output.time", { "data-key": "time" });
    this.pace = el("output.pace");
    const step = (text, title, by) => el("button", { type: "button", title, "aria-label": title,
      onclick: () => this.faster(by) }, text);
    host.replaceChildren(this.button, this.readout, this.track,
      el("div.speed", {}, step("−", "Slower", -1), this.pace, step("+", "Faster", 1)));
    window.addEventListener("keydown", (event) => this.key(event));
    this.sayRate();
    this.sayButton();
  }

  // index of the saved time nearest to the cursor
  get sample() {
    return nearest(this.times, this.now);
  }

  go(time) {
    this.now = Math.min(Math.max(time, this.times[0]), this.last);
    this.track.value = this.sample;
    const share = (this.now - this.times[0]) / (this.last - this.times[0] || 1);
    this.track.style.setProperty("--done", `${(100 * share).toFixed(2)}%`);
    // in play the time runs on between saved times; at rest it is the saved one that is shown
    const told = this.playing ? this.now : this.times[this.sample];
    this.readout.textContent = `${shown(told, this.scale)} ${this.scale.unit}`;
    this.track.setAttribute("aria-valuetext", this.readout.textContent);
    this.onchange();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.now >= this.last) this.now = this.times[0];
    this.playing = true;
    this.sayButton();
    let before = performance.now();
    const tick = (wall) => {
      if (!this.playing) return;
      const next = this.now + Math.max(wall - before, 0) * 1e-3 * this.rate;
      before = wall;
      this.go(next);
      if (next >= this.last) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.sayButton();
    this.go(this.times[this.sample]);
  }

  faster(by) {
    this.rate = nice(this.rate * (by > 0 ? 2.2 : 1 / 2.2));
    this.sayRate();
  }

  sayRate() {
    const times = this.rate < 1 ? 1 / this.rate : this.rate;
    const text = String(Number(times.toPrecision(3)));
    this.pace.textContent = this.rate === 1 ? "real time"
      : `${text}× ${this.rate < 1 ? "slower" : "faster"}`;
    this.pace.title = "than real time";
  }

  sayButton() {
    this.button.dataset.state = this.playing ? "playing" : "paused";
    const name = this.playing ? "Pause" : "Play";
    this.button.title = `${name} (space)`;
    this.button.setAttribute("aria-label", name);
  }

  key(event) {
    if (/INPUT|SELECT|TEXTAREA|BUTTON|SUMMARY/.test(event.target.tagName) && event.target !== this.track) return;
    const jump = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === " ") this.toggle();
    else if (jump && event.target !== this.track) {
      this.pause();
      this.go(this.times[Math.min(Math.max(this.sample + jump, 0), this.times.length - 1)]);
    } else if (event.key === "Home") this.go(this.times[0]);
    else if (event.key === "End") this.go(this.last);
    else return;
    event.preventDefault();
  }
}

function nice(rate) {
  const power = 10 ** Math.floor(Math.log10(rate));
  const best = [1, 2, 5, 10].reduce((a, b) =>
    (Math.abs(Math.log(b * power / rate)) < Math.abs(Math.log(a * power / rate)) ? b : a));
  return Number((best * power).toPrecision(3));
}

export function nearest(sorted, value) {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle;
    else high = middle;
  }
  return value - sorted[low] <= sorted[high] - value ? low : high;
}
