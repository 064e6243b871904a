// Elements in one line: el("button.flat", { title: "Play", onclick: go }, "text", child)

export function el(what, attributes = {}, ...children) {
  const [tag, ...classes] = what.split(".");
  const made = document.createElement(tag || "div");
  if (classes.length) made.className = classes.join(" ");
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value != null) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child != null && child !== false));
  return made;
}

export function select(label, items, onchange, attributes = {}) {
  const box = el("select", { "aria-label": label, ...attributes },
    ...items.map(([value, text]) => el("option", { value }, text)));
  box.addEventListener("change", () => onchange(box.value));
  return box;
}

export function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
