// Numbers as people read them. Every quantity has one unit on the whole page, so that digits keep
// their places while a value runs.

// digits after the point for about four in all at the largest magnitude
export function places(top) {
  if (!(top >= 5e-7)) return 0; // of less no digit would show
  return Math.min(Math.max(3 - Math.floor(Math.log10(top)), 0), 6);
}

export function fixed(value, digits) {
  if (value == null || !Number.isFinite(value)) return "–";
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

export function shown(value, scale) {
  return fixed(value * scale.factor, places(scale.top));
}

// 1-2-5 steps for about `count` ticks over [low, high]
export function ticks(low, high, count) {
  const span = high - low;
  if (!(span > 0)) return { step: 1, at: [low] };
  const rough = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const sizes = [0.5, 1, 2, 5, 10].map((m) => m * power);
  const k = sizes.findIndex((size, i) => i > 0 && size >= rough * 0.999);
  const found = between(low, high, sizes[k]);
  return found.at.length > 1 ? found : between(low, high, sizes[k - 1]); // one tick tells no scale
}

function between(low, high, step) {
  const at = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) at.push(k * step);
  return { step, at };
}

export function tickText(value, step) {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return fixed(value, Math.min(digits, 8));
}
