"use strict";
// Draws the charts of the page: one time axis for all of them, dragged, wheeled, pinched or set by the buttons.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const LEFT = 58, RIGHT = 10, BOTTOM = 22, HEIGHT = 190;
  const charts = [];
  let colours = {}, full = [0, 1], view = [0, 1], isPending = false;

  const element = (tag, parent, name = "", text = "") => {
    const made = document.createElement(tag);
    if (name) made.className = name;
    if (text) made.textContent = text;
    parent.appendChild(made);
    return made;
  };
  const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

  // ---- data ----
  function unpack(series) {
    let ms = 0;
    series.t = Float64Array.from(series.t, (step) => (ms += step) / 1000);
    series.v = Float64Array.from(series.v);
    const steps = Array.from(series.t.slice(1), (t, i) => t - series.t[i]).sort((a, b) => a - b);
    series.gap = Math.max(1, 6 * (steps[steps.length >> 1] || 0)); // a longer pause breaks the line
    series.shown = true;
  }
  function findSpan() {
    let low = Infinity, high = -Infinity;
    const take = (a, b) => { low = Math.min(low, a); high = Math.max(high, b); };
    for (const chart of data.charts) for (const s of chart.series) if (s.t.length) take(s.t[0], s.t[s.t.length - 1]);
    for (const one of data.verdict) take(one.begin, one.end);
    return [0, low <= high ? Math.max(high, 1) : 1]; // log time counts from the first inertial sample
  }
  // Index of the first point at or after t.
  function firstAfter(times, t) {
    let low = 0, high = times.length;
    while (low < high) { const mid = (low + high) >> 1; if (times[mid] < t) low = mid + 1; else high = mid; }
    return low;
  }

  // ---- axes ----
  function linearTicks(low, high, count) {
    const rough = (high - low) / Math.max(1, count), power = 10 ** Math.floor(Math.log10(rough)), ticks = [];
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999);
    for (let k = Math.ceil(low / step); k * step <= high + step * 1e-9; k++) ticks.push(k * step);
    return { ticks, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
  }
  function logTicks(low, high) {
    const ticks = [], factors = high / low < 50 ? [1, 2, 5] : [1];
    for (let e = Math.floor(Math.log10(low)); 10 ** e <= high; e++) ticks.push(...factors.map((f) => f * 10 ** e));
    return { ticks: ticks.filter((v) => v >= low && v <= high) };
  }
  const label = (value, digits) => (value === 0 ? 0 : value).toFixed(Math.min(digits, 6)).replace("-", "−");
  function reading(value) {
    const digits = value === 0 ? 0 : Math.abs(value) >= 100 ? 1 : Math.abs(value) >= 1 ? 2 : Math.abs(value) >= 0.01 ? 3 : 4;
    return label(value, digits);
  }
  function valueRange(chart) {
    let low = Infinity, high = -Infinity;
    const take = (v) => { if (!chart.log || v > 0) { low = Math.min(low, v); high = Math.max(high, v); } };
    for (const s of chart.series) {
      if (!s.shown) continue;
      const begin = Math.max(0, firstAfter(s.t, view[0]) - 1), end = Math.min(s.t.length, firstAfter(s.t, view[1]) + 1);
      for (let i = begin; i < end; i++) take(s.v[i]);
    }
    if (low > high) [low, high] = chart.log ? [0.1, 10] : [-1, 1];
    if (chart.log) {
      for (const line of chart.lines) take(line.value);
      high *= 1.4; // of smaller values than three and a half decades below it, all that matters is that they are small
      low = Math.max(low / 1.4, high / 10 ** 3.5);
      return low / high > 0.2 ? [low / 2, high * 1.5] : [low, high];
    }
    for (const line of chart.lines) {
      const reach = 0.6 * Math.max(high - low, Math.abs(high));
      if (line.value > low - reach && line.value < high + reach) take(line.value);
    }
    const largest = Math.max(Math.abs(low), Math.abs(high));
    const margin = high - low > 1e-4 * largest ? 0.06 * (high - low) : 0.1 * largest || 1;
    return low >= 0 && low - margin < 0 ? [0, high + margin] : [low - margin, high + margin];
  }

  // ---- drawing ----
  function readColours() {
    const style = getComputedStyle(document.documentElement);
    const names = "card ink soft rule axis ours autopilot reference verdict sigma agree undecided disagree fault line " +
      "part0 part1 part2 part3 part4";
    colours = Object.fromEntries(names.split(" ").map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
    for (const key of document.querySelectorAll(".key i")) key.style.background = colours[key.dataset.role];
  }
  function prepared(canvas, height) {
    const width = canvas.parentNode.clientWidth, ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.height = `${height}px`;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = '11px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
    return [pen, width];
  }
  const place = (t, width) => LEFT + ((t - view[0]) / (view[1] - view[0])) * (width - LEFT - RIGHT);
  const placed = (one, width) => [one.begin, one.end].map((t) => clamp(place(t, width), LEFT, width - RIGHT));
  const timeAt = (x, width) => view[0] + ((x - LEFT) / (width - LEFT - RIGHT)) * (view[1] - view[0]);

  function fillFaintly(pen, colour, alpha, ...box) {
    pen.fillStyle = colour;
    pen.globalAlpha = alpha;
    pen.fillRect(...box);
    pen.globalAlpha = 1;
  }
  function drawTimeAxis(pen, width, height, isGrid) {
    const { ticks, digits } = linearTicks(view[0], view[1], (width - LEFT) / 65);
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const t of ticks) {
      const x = place(t, width);
      if (isGrid) { pen.fillStyle = colours.rule; pen.fillRect(Math.round(x), 0, 1, height - BOTTOM); }
      pen.fillStyle = colours.soft;
      if (x < width - 18) pen.fillText(`${label(t, digits)} s`, x, height - BOTTOM + 6);
    }
  }
  function drawValueAxis(pen, chart, width, height, yOf, low, high) {
    const { ticks, digits } = chart.log ? logTicks(low, high) : linearTicks(low, high, height / 45);
    const text = (v) => (chart.log ? String(Number(v.toPrecision(1))) : label(v, digits));
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const v of ticks) {
      const y = yOf(v);
      pen.fillStyle = colours.rule;
      pen.fillRect(LEFT, Math.round(y), width - LEFT - RIGHT, 1);
      pen.fillStyle = colours.soft;
      pen.fillText(text(v), LEFT - 6, clamp(y, 6, height - BOTTOM - 4));
    }
  }
  function tracePath(pen, chart, s, width, yOf) {
    const begin = Math.max(0, firstAfter(s.t, view[0]) - 1), end = Math.min(s.t.length, firstAfter(s.t, view[1]) + 1);
    const runs = [];
    let run;
    for (let i = begin; i < end; i++) {
      const isBroken = i > begin && (s.t[i] - s.t[i - 1] > s.gap || (chart.wraps && Math.abs(s.v[i] - s.v[i - 1]) > 180));
      if (!run || isBroken) runs.push((run = []));
      run.push([place(s.t[i], width), yOf(s.v[i])]);
    }
    return runs;
  }
  function drawSeries(pen, chart, s, width, yOf, floor) {
    pen.strokeStyle = pen.fillStyle = colours[s.role];
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    for (const run of tracePath(pen, chart, s, width, yOf)) {
      pen.beginPath();
      run.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      if (s.role === "sigma") {
        pen.lineTo(run[run.length - 1][0], floor);
        pen.lineTo(run[0][0], floor);
        pen.globalAlpha = 0.3;
        pen.fill();
        pen.globalAlpha = 1;
      } else if (run.length === 1) {
        pen.fillRect(run[0][0] - 1.5, run[0][1] - 1.5, 3, 3);
      } else pen.stroke();
    }
  }
  function drawLines(pen, chart, width, yOf, low, high) {
    pen.textAlign = "right";
    pen.textBaseline = "bottom";
    for (const line of chart.lines) {
      if (line.value < low || line.value > high) continue;
      const y = yOf(line.value);
      pen.strokeStyle = pen.fillStyle = colours.line;
      pen.lineWidth = 1;
      pen.setLineDash([5, 4]);
      pen.beginPath();
      pen.moveTo(LEFT, y);
      pen.lineTo(width - RIGHT, y);
      pen.stroke();
      pen.setLineDash([]);
      const textWidth = pen.measureText(line.label).width, top = y > 16 ? y - 15 : y + 2;
      fillFaintly(pen, colours.card, 0.75, width - RIGHT - textWidth - 6, top, textWidth + 6, 14);
      pen.fillStyle = colours.soft;
      pen.fillText(line.label, width - RIGHT - 3, top + 13);
    }
  }
  function drawBackground(pen, width, height) {
    for (const one of data.verdict) {
      const [a, b] = placed(one, width);
      if (one.state === "disagree" && b > a) fillFaintly(pen, colours.disagree, 0.1, a, 0, b - a, height - BOTTOM);
    }
  }
  function drawChart(chart) {
    const [pen, width] = prepared(chart.canvas, HEIGHT), [low, high] = valueRange(chart), floor = HEIGHT - BOTTOM;
    const scale = chart.log ? (v) => Math.log10(Math.max(v, low)) : (v) => v;
    const yOf = (v) => 4 + (floor - 4) * (1 - (scale(v) - scale(low)) / (scale(high) - scale(low)));
    drawBackground(pen, width, HEIGHT);
    drawTimeAxis(pen, width, HEIGHT, true);
    drawValueAxis(pen, chart, width, HEIGHT, yOf, low, high);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, 0, width - LEFT - RIGHT, floor + 1);
    pen.clip();
    for (const s of chart.series) if (s.shown) drawSeries(pen, chart, s, width, yOf, floor);
    pen.restore();
    drawLines(pen, chart, width, yOf, low, high);
  }

  // ---- timeline: verdict, lanes with their faults, events ----
  const strip = { hits: [] };
  function stripRows() {
    const rows = [{ name: "verdict", height: 18, bands: data.verdict.map((one) => ({ ...one, colour: one.state })) }];
    for (const lane of data.lanes) {
      const bands = lane.faults.map((one) => ({ ...one, end: one.end === null ? full[1] : one.end, colour: "fault" }));
      rows.push({ name: lane.name, height: 10, base: "agree", bands });
    }
    if (data.marks.length) rows.push({ name: "events", height: 14, marks: data.marks });
    return rows;
  }
  function drawBand(pen, band, y, height, width) {
    const [a, b] = placed(band, width);
    if (band.end < view[0] || band.begin > view[1]) return;
    const shown = Math.max(2, b - a); // a short interval stays visible
    pen.fillStyle = colours[band.colour];
    pen.fillRect(a, y, shown, height);
    strip.hits.push({ x: a, y, width: shown, height, text: band.text });
    const word = { agree: "agree", undecided: "undecided", disagree: "DISAGREE" }[band.state];
    if (word && shown > pen.measureText(word).width + 12) {
      pen.fillStyle = band.state === "undecided" ? colours.ink : "#ffffff";
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      pen.fillText(word, a + shown / 2, y + height / 2 + 0.5);
    }
  }
  function drawMarks(pen, marks, y, height, width) {
    for (const mark of marks) {
      if (mark.t < view[0] || mark.t > view[1]) continue;
      const x = place(mark.t, width);
      pen.fillStyle = mark.own ? colours.ours : colours.autopilot;
      pen.beginPath();
      pen.moveTo(x, y + 1);
      pen.lineTo(x + 5, y + height - 2);
      pen.lineTo(x - 5, y + height - 2);
      pen.fill();
      strip.hits.push({ x: x - 5, y, width: 10, height, text: `${reading(mark.t)} s: ${mark.text}` });
    }
  }
  function drawTimeline() {
    const rows = stripRows(), total = rows.reduce((sum, row) => sum + row.height + 4, 0) + 16;
    const [pen, width] = prepared(strip.canvas, total);
    strip.hits = [];
    let y = 2;
    for (const row of rows) {
      pen.fillStyle = colours.soft;
      pen.textAlign = "right";
      pen.textBaseline = "middle";
      pen.fillText(row.name.replace("SCALED_", "").slice(0, 8), LEFT - 5, y + row.height / 2);
      if (row.base) fillFaintly(pen, colours[row.base], 0.35, LEFT, y + row.height / 2 - 2, width - LEFT - RIGHT, 4);
      for (const band of row.bands || []) drawBand(pen, band, y, row.height, width);
      drawMarks(pen, row.marks || [], y, row.height, width);
      y += row.height + 4;
    }
    drawTimeAxis(pen, width, total + 6, false);
  }
  function redraw() {
    isPending = false;
    drawTimeline();
    charts.forEach(drawChart);
    range.textContent = `${reading(view[0])} to ${reading(view[1])} s`;
    document.body.dataset.begin = view[0];
    document.body.dataset.end = view[1];
  }
  function refresh() {
    if (!isPending) { isPending = true; requestAnimationFrame(redraw); }
  }

  // ---- interaction ----
  function show(begin, end) {
    const length = clamp(end - begin, Math.min(0.05, full[1] - full[0]), full[1] - full[0]);
    const start = clamp(begin, full[0], full[1] - length);
    view = [start, start + length];
    refresh();
  }
  const zoom = (factor, t) => show(t - (t - view[0]) * factor, t + (view[1] - t) * factor);
  const middle = () => (view[0] + view[1]) / 2;
  const pan = (share) => show(view[0] + share * (view[1] - view[0]), view[1] + share * (view[1] - view[0]));

  function showCursor(t) {
    for (const chart of charts) {
      const width = chart.canvas.parentNode.clientWidth, isInside = t !== null && t >= view[0] && t <= view[1];
      chart.cursor.style.display = isInside ? "block" : "none";
      if (isInside) chart.cursor.style.left = `${place(t, width)}px`;
      for (const s of chart.series) s.reading.textContent = isInside ? near(s, t, chart.unit) : "";
    }
  }
  function near(s, t, unit) {
    let i = firstAfter(s.t, t);
    if (i === s.t.length || (i > 0 && t - s.t[i - 1] < s.t[i] - t)) i--;
    return i < 0 || Math.abs(s.t[i] - t) > s.gap ? "" : `${reading(s.v[i])}${unit.startsWith("°") ? unit : unit && ` ${unit}`}`;
  }
  // Mouse: drag selects, with shift it moves. Touch: one finger moves sideways, two zoom.
  function attach(canvas, selection) {
    const fingers = new Map();
    let start = null;
    const at = (event) => event.clientX - canvas.getBoundingClientRect().left;
    const width = () => canvas.parentNode.clientWidth;
    canvas.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, at(event));
      canvas.setPointerCapture(event.pointerId);
      const isMoving = event.shiftKey || event.pointerType === "touch" || selection === null;
      start = { x: at(event), view: [...view], isMoving, xs: [...fingers.values()] };
    });
    canvas.addEventListener("pointermove", (event) => {
      const x = at(event);
      showCursor(timeAt(x, width()));
      if (!start || !fingers.has(event.pointerId)) return;
      fingers.set(event.pointerId, x);
      const perPixel = (start.view[1] - start.view[0]) / (width() - LEFT - RIGHT);
      if (fingers.size === 2) {
        const [a, b] = [...fingers.values()], [c, d] = start.xs;
        const factor = clamp(Math.abs(c - d) / Math.max(10, Math.abs(a - b)), 0.02, 50);
        const t = start.view[0] + ((c + d) / 2 - LEFT) * perPixel, left = (a + b) / 2 - LEFT;
        show(t - left * perPixel * factor, t - left * perPixel * factor + (start.view[1] - start.view[0]) * factor);
      } else if (start.isMoving) {
        const moved = (start.x - x) * perPixel;
        show(start.view[0] + moved, start.view[1] + moved);
      } else {
        const [a, b] = [start.x, x].map((one) => clamp(one, LEFT, width() - RIGHT)).sort((p, q) => p - q);
        Object.assign(selection.style, { display: "block", left: `${a}px`, width: `${b - a}px` });
      }
    });
    const end = (event) => {
      const begun = start, x = at(event);
      fingers.delete(event.pointerId);
      start = null;
      if (selection) selection.style.display = "none";
      if (event.type !== "pointerup" || !begun || begun.isMoving || Math.abs(x - begun.x) < 4) return;
      const [a, b] = [begun.x, x].map((one) => timeAt(clamp(one, LEFT, width() - RIGHT), width())).sort((p, q) => p - q);
      show(a, b);
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("pointerleave", () => showCursor(null));
    canvas.addEventListener("dblclick", () => show(...full));
    canvas.addEventListener("wheel", (event) => {
      const isSideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
      if (!event.ctrlKey && !isSideways) return; // the wheel alone scrolls the page
      event.preventDefault();
      if (isSideways) pan(event.deltaX / width());
      else zoom(Math.exp(0.002 * clamp(event.deltaY, -200, 200)), timeAt(at(event), width()));
    }, { passive: false });
  }
  function attachTip(canvas) {
    const tip = element("div", document.body);
    tip.id = "tip";
    const move = (event) => {
      const box = canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      const hits = strip.hits.filter((h) => x >= h.x - 2 && x <= h.x + h.width + 2 && y >= h.y && y <= h.y + h.height);
      tip.textContent = hits.slice(-8).map((h) => h.text).join("\n");
      tip.style.display = hits.length ? "block" : "none";
      tip.style.left = `${clamp(event.clientX + 10, 4, window.innerWidth - tip.offsetWidth - 4)}px`;
      tip.style.top = `${event.clientY + 16}px`;
    };
    canvas.addEventListener("pointermove", move);
    canvas.addEventListener("pointerdown", move);
    canvas.addEventListener("pointerleave", () => (tip.style.display = "none"));
  }

  // ---- page ----
  function makeTimeline() {
    const parent = document.getElementById("timeline"), tools = element("div", parent, "tools");
    const button = (text, name, action) => {
      const made = element("button", tools, "", text);
      made.title = name;
      made.setAttribute("aria-label", name);
      made.addEventListener("click", action);
    };
    button("+", "Zoom in", () => zoom(0.5, middle()));
    button("−", "Zoom out", () => zoom(2, middle()));
    button("◀", "Earlier", () => pan(-0.4));
    button("▶", "Later", () => pan(0.4));
    button("Whole flight", "Show the whole flight", () => show(...full));
    const shown = element("span", tools, "range");
    element("span", tools, "hint", "Drag to zoom, shift and drag to move, double click for the whole flight.");
    strip.canvas = element("canvas", element("div", parent, "plot"));
    return shown;
  }
  function makeChart(parent, chart) {
    const figure = element("figure", parent), caption = element("figcaption", figure);
    element("strong", caption, "", chart.unit ? `${chart.title}, ${chart.unit}` : chart.title);
    for (const s of chart.series) {
      const key = element("button", caption, "key");
      element("i", key).dataset.role = s.role;
      element("span", key, "", s.label);
      s.reading = element("b", key);
      key.addEventListener("click", () => { s.shown = !s.shown; key.classList.toggle("off", !s.shown); refresh(); });
    }
    const plot = element("div", figure, "plot");
    chart.canvas = element("canvas", plot);
    chart.canvas.setAttribute("role", "img");
    chart.canvas.setAttribute("aria-label", chart.title);
    chart.cursor = element("div", plot, "cursor");
    attach(chart.canvas, element("div", plot, "selection"));
    charts.push(chart);
  }

  for (const chart of data.charts) chart.series.forEach(unpack);
  full = findSpan();
  view = [...full];
  const range = makeTimeline(), main = document.getElementById("charts");
  let section = "";
  for (const chart of data.charts) {
    if (chart.section !== section) element("h2", main, "", (section = chart.section));
    makeChart(main, chart);
  }
  attach(strip.canvas, null);
  attachTip(strip.canvas);
  readColours();
  redraw();
  window.addEventListener("resize", refresh);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); refresh(); });
  const setPrint = (isPrint) => () => {
    document.documentElement.classList.toggle("print", isPrint);
    readColours();
    redraw();
  };
  window.addEventListener("beforeprint", setPrint(true));
  window.addEventListener("afterprint", setPrint(false));
})();
