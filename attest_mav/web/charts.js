// Charts over time. view: the state (now), its points, and the span of time that is shown, s (spanS).
import { colours, prepared } from "./elements.js";

const LEFT = 40, BOTTOM = 18;

const placed = (view, t, width) => LEFT + (1 - (view.now.now_s - t) / view.spanS) * (width - LEFT - 4);
function drawTimes(view, pen, width, height) {
  pen.fillStyle = colours.soft;
  pen.textAlign = "center";
  pen.textBaseline = "top";
  const parts = width < 500 ? 2 : 6;
  for (let i = 0; i <= parts; i++) {
    const ago = (i * view.spanS) / parts, x = placed(view, view.now.now_s - ago, width);
    pen.fillText(i ? `−${ago} s` : "now", Math.min(x, width - 14), height - BOTTOM + 4);
  }
}
export function drawBand(view) {
  const [pen, width, height] = prepared("band"), now = view.now;
  pen.fillStyle = colours.rule;
  pen.fillRect(LEFT, 0, width - LEFT - 4, height - BOTTOM);
  now.spans.forEach((span, i) => {
    const end = i + 1 < now.spans.length ? now.spans[i + 1].begin_s : now.now_s;
    const a = Math.max(LEFT, placed(view, span.begin_s, width)), b = placed(view, end, width);
    if (b <= LEFT) return;
    pen.fillStyle = colours[span.agreement];
    pen.fillRect(a, 0, Math.max(1.5, b - a), height - BOTTOM);
    if (b - a > 60 && span.reason !== "agrees") {
      pen.fillStyle = span.agreement === "undecided" ? colours.ink : "white";
      pen.textAlign = "left";
      pen.textBaseline = "middle";
      pen.fillText(span.reason, a + 5, (height - BOTTOM) / 2, b - a - 8);
    }
  });
  drawTimes(view, pen, width, height);
}
export function drawChart(view, id, value, sigma, threshold) {
  const [pen, width, height] = prepared(id), floor = height - BOTTOM, points = view.points;
  const xOf = (t) => placed(view, t, width);
  const shown = points.filter((one) => one[value] !== null);
  const largest = Math.max(threshold || 0, 1, ...shown.map((one) => one[value])) * 1.15;
  const yOf = (v) => floor - (Math.min(v, largest) / largest) * (floor - 4);
  const step = [0.5, 1, 2, 5, 10, 20, 50].find((one) => largest / one <= 5) || 90;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (let v = 0; v <= largest; v += step) {
    pen.fillStyle = colours.rule;
    pen.fillRect(LEFT, Math.round(yOf(v)), width - LEFT - 4, 1);
    pen.fillStyle = colours.soft;
    pen.fillText(String(v), LEFT - 6, Math.max(6, yOf(v)));
  }
  drawTimes(view, pen, width, height);
  pen.fillStyle = colours.sigma;
  pen.globalAlpha = 0.35;
  points.forEach((one, i) => {
    const next = points[i + 1] || one;
    if (one[sigma] === null || next.t - one.t > 2) return;
    const x = Math.round(xOf(one.t));
    pen.fillRect(x, yOf(one[sigma]), Math.round(xOf(next.t)) - x, floor - yOf(one[sigma]));
  });
  pen.globalAlpha = 1;
  drawLine(pen, points, value, [xOf, yOf], threshold ?? Infinity);
  if (threshold !== null) {
    pen.strokeStyle = colours.line;
    pen.setLineDash([5, 4]);
    pen.beginPath();
    pen.moveTo(LEFT, yOf(threshold));
    pen.lineTo(width - 4, yOf(threshold));
    pen.stroke();
    pen.setLineDash([]);
  }
}
function drawLine(pen, points, value, [xOf, yOf], threshold) {
  let last = null;
  pen.lineWidth = 1.5;
  for (const one of points) {
    if (one[value] !== null && last !== null && one.t - last.t < 2) {
      pen.strokeStyle = one[value] > threshold ? colours.disagree : colours.ours;
      pen.beginPath();
      pen.moveTo(xOf(last.t), yOf(last[value]));
      pen.lineTo(xOf(one.t), yOf(one[value]));
      pen.stroke();
    }
    last = one[value] === null ? null : one;
  }
}
