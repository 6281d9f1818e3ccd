// Elements of the page: their text, their canvases and the colours of its style.
export const byId = (id) => document.getElementById(id);
export const fixed = (value, digits, sign = "") => {
  if (value === null || value === undefined) return "–";
  const text = Math.abs(value).toFixed(digits); // a number that rounds to zero has no sign
  return (Number(text) === 0 ? "" : value < 0 ? "−" : sign) + text;
};
export const size = (value, digits) => (value === null ? "–" : `${fixed(Math.abs(value), digits)}°`);
export const put = (id, text) => { if (byId(id).textContent !== text) byId(id).textContent = text; };

export let colours = {};
export function readColours() {
  const style = getComputedStyle(document.documentElement);
  const names = "card ink soft rule axis ours autopilot sigma agree undecided disagree line".split(" ");
  colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}
export function prepared(id) {
  const canvas = byId(id), ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  pen.font = '11px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
  return [pen, width, height];
}
