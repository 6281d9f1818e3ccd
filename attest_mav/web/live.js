"use strict";
// Draws the state of the daemon as it comes, four times a second. Whatever is old is marked, and never shown as live.
(() => {
  const LONGEST_S = 600, OLD_S = 1.5, SILENT_MS = 3000, MAX_POINTS = 2400, LEFT = 40, BOTTOM = 18;
  const points = [];
  const UNFIT = ["inflated", "outside_gate", "implausible", "too_old"]; // uses of a measurement that did not fit
  let now = null, before = null, heardMs = 0, spanS = 60, colours = {};

  const byId = (id) => document.getElementById(id);
  const fixed = (value, digits, sign = "") => {
    if (value === null || value === undefined) return "–";
    const text = Math.abs(value).toFixed(digits); // a number that rounds to zero has no sign
    return (Number(text) === 0 ? "" : value < 0 ? "−" : sign) + text;
  };
  const size = (value, digits) => (value === null ? "–" : `${fixed(Math.abs(value), digits)}°`);
  const published = (state) => state.lanes.find((lane) => lane.estimate !== null);
  const put = (id, text) => { if (byId(id).textContent !== text) byId(id).textContent = text; };

  // ---- canvases ----
  function readColours() {
    const style = getComputedStyle(document.documentElement);
    const names = "card ink soft rule axis ours autopilot sigma agree undecided disagree line".split(" ");
    colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  }
  function prepared(id) {
    const canvas = byId(id), ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = '11px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
    return [pen, width, height];
  }

  // ---- artificial horizon ----
  function drawHorizon(id, attitude, colour) {
    const [pen, width, height] = prepared(id), radius = Math.max(0, Math.min(width, height) / 2 - 4); // nothing is laid out in a window without a size
    pen.translate(width / 2, height / 2);
    const rim = () => {
      pen.beginPath();
      pen.arc(0, 0, radius, 0, 2 * Math.PI);
    };
    rim();
    pen.save();
    pen.clip();
    if (attitude === null) {
      pen.fillStyle = colours.rule;
      pen.fillRect(-radius, -radius, 2 * radius, 2 * radius);
    } else drawSky(pen, attitude, radius);
    pen.restore();
    rim(); // the path of the sky is not undone with its colours
    pen.strokeStyle = colours.axis;
    pen.stroke();
    if (attitude !== null) drawAircraft(pen, radius, colour);
  }
  function drawSky(pen, attitude, radius) {
    const scale = radius / 40, reach = 4 * radius;
    pen.rotate((-attitude.roll_deg * Math.PI) / 180);
    pen.translate(0, attitude.pitch_deg * scale);
    pen.fillStyle = "#4c8fd6";
    pen.fillRect(-reach, -90 * scale - reach, 2 * reach, 90 * scale + reach);
    pen.fillStyle = "#8a6238";
    pen.fillRect(-reach, 0, 2 * reach, 90 * scale + reach);
    pen.strokeStyle = pen.fillStyle = "white";
    pen.textBaseline = "middle";
    for (let pitch = -80; pitch <= 80; pitch += 10) {
      const half = pitch === 0 ? reach : pitch % 20 === 0 ? radius * 0.3 : radius * 0.16, y = -pitch * scale;
      pen.lineWidth = pitch === 0 ? 2 : 1;
      pen.beginPath();
      pen.moveTo(-half, y);
      pen.lineTo(half, y);
      pen.stroke();
      if (pitch !== 0 && pitch % 20 === 0) pen.fillText(String(Math.abs(pitch)), half + 4, y);
    }
  }
  function drawAircraft(pen, radius, colour) {
    const wings = () => {
      pen.beginPath();
      pen.moveTo(-radius * 0.55, 0);
      pen.lineTo(-radius * 0.18, 0);
      pen.lineTo(0, radius * 0.12);
      pen.lineTo(radius * 0.18, 0);
      pen.lineTo(radius * 0.55, 0);
      pen.stroke();
    };
    pen.lineJoin = "round";
    pen.strokeStyle = "white";
    pen.lineWidth = 6;
    wings();
    pen.strokeStyle = colour;
    pen.lineWidth = 3;
    wings();
  }
  function showAttitude(id, attitude, colour, note) {
    const age = attitude === null ? null : now.now_s - attitude.received_s, isOld = age === null || age > OLD_S;
    drawHorizon(id, attitude, colour);
    byId(id).classList.toggle("dead", isOld);
    byId(`${id}-numbers`).classList.toggle("dead", isOld);
    byId(`${id}-note`).className = isOld ? "old" : "";
    put(`${id}-note`, attitude === null ? "none" : isOld ? `old: ${fixed(age, 1)} s ago` : note);
    put(`${id}-numbers`, attitude === null ? "–" :
      `roll ${fixed(attitude.roll_deg, 1, "+")}°  pitch ${fixed(attitude.pitch_deg, 1, "+")}°  ` +
      `heading ${fixed(attitude.yaw_deg, 1)}°`);
  }

  // ---- charts over time ----
  const placed = (t, width) => LEFT + (1 - (now.now_s - t) / spanS) * (width - LEFT - 4);
  function drawTimes(pen, width, height) {
    pen.fillStyle = colours.soft;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const parts = width < 500 ? 2 : 6;
    for (let i = 0; i <= parts; i++) {
      const ago = (i * spanS) / parts, x = placed(now.now_s - ago, width);
      pen.fillText(i ? `−${ago} s` : "now", Math.min(x, width - 14), height - BOTTOM + 4);
    }
  }
  function drawBand() {
    const [pen, width, height] = prepared("band");
    pen.fillStyle = colours.rule;
    pen.fillRect(LEFT, 0, width - LEFT - 4, height - BOTTOM);
    now.spans.forEach((span, i) => {
      const end = i + 1 < now.spans.length ? now.spans[i + 1].begin_s : now.now_s;
      const a = Math.max(LEFT, placed(span.begin_s, width)), b = placed(end, width);
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
    drawTimes(pen, width, height);
  }
  function drawChart(id, value, sigma, threshold) {
    const [pen, width, height] = prepared(id), floor = height - BOTTOM;
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
    drawTimes(pen, width, height);
    pen.fillStyle = colours.sigma;
    pen.globalAlpha = 0.35;
    points.forEach((one, i) => {
      const next = points[i + 1] || one;
      if (one[sigma] === null || next.t - one.t > 2) return;
      const x = Math.round(placed(one.t, width));
      pen.fillRect(x, yOf(one[sigma]), Math.round(placed(next.t, width)) - x, floor - yOf(one[sigma]));
    });
    pen.globalAlpha = 1;
    drawLine(pen, value, width, yOf, threshold ?? Infinity);
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
  function drawLine(pen, value, width, yOf, threshold) {
    let last = null;
    pen.lineWidth = 1.5;
    for (const one of points) {
      if (one[value] !== null && last !== null && one.t - last.t < 2) {
        pen.strokeStyle = one[value] > threshold ? colours.disagree : colours.ours;
        pen.beginPath();
        pen.moveTo(placed(last.t, width), yOf(last[value]));
        pen.lineTo(placed(one.t, width), yOf(one[value]));
        pen.stroke();
      }
      last = one[value] === null ? null : one;
    }
  }

  // ---- tables ----
  function fill(id, head, rows) {
    const table = byId(id), text = JSON.stringify(rows);
    if (table.dataset.shown === text) return;
    table.dataset.shown = text;
    const cell = (tag, [words, kind]) => {
      const made = document.createElement(tag);
      made.textContent = words;
      if (kind) made.className = kind;
      return made;
    };
    const line = (tag, cells) => {
      const made = document.createElement("tr");
      made.append(...cells.map((one) => cell(tag, Array.isArray(one) ? one : [one, ""])));
      return made;
    };
    table.replaceChildren(line("th", head), ...rows.map((row) => line("td", row)));
  }
  const perSecond = (count, earlier) =>
    before === null || earlier === undefined || now.now_s <= before.now_s ? null
      : Math.max(0, (count - earlier) / (now.now_s - before.now_s));
  function showTables() {
    const kinds = { agree: "", undecided: "doubt", disagree: "bad" };
    fill("spans", ["verdict", "reason", "ago", "for", "tilt ≤", "heading ≤"], now.spans.slice(-12).reverse().map((span, i) => {
      const end = i === 0 ? now.now_s : span.end_s;
      return [[span.agreement, kinds[span.agreement]], span.reason, `${fixed(now.now_s - span.begin_s, 0)} s`,
        `${fixed(end - span.begin_s, 0)} s`, size(span.tilt_deg, 1), size(span.heading_deg, 1)];
    }));
    fill("lanes", ["sensor", "state", "rate", "rests on", "delay"], now.lanes.map((lane) => {
      const earlier = before && before.lanes.find((one) => one.source === lane.source);
      const rate = perSecond(lane.samples, earlier?.samples), isSilent = rate === 0;
      const state = lane.fault ? [`set aside: ${lane.fault}`, "bad text"] : isSilent ? ["no samples", "bad"] :
        lane.estimate ? "published" : "used beside it";
      return [lane.source, state, `${fixed(rate, 0)} Hz`, [(!isSilent && lane.rests_on) || "–", "text"],
        isSilent ? "–" : `${fixed(lane.delay_s * 1000, 0)} ms`];
    }));
    fill("aids", ["aid", "seen", "use", "innovation", "NIS"], now.aids.map((one) => [
      one.aid.replaceAll("_", " "), `${fixed(now.now_s - one.received_s, 0)} s ago`,
      [one.fusion.replaceAll("_", " "), UNFIT.includes(one.fusion) ? "doubt" : ""],
      [one.residual.map((value) => fixed(value, 3, "+")).join("  ") || "–", "text"], fixed(one.nis, 1)]));
    fill("messages", ["message", "rate", "asked for", "remark"], now.streams.map((stream) => [stream.name,
      [`${fixed(stream.achieved_hz, 1)} Hz`, stream.achieved_hz < 0.8 * stream.hz ? "doubt" : ""],
      `${fixed(stream.hz, 0)} Hz`, [stream.hindrance || (stream.answer === "accepted" ? "" : stream.answer), "text"]]));
    fill("links", ["link", "state", "received", "damaged", "lost", "attitudes"], now.links.map((link, i) => {
      const earlier = before?.links[i];
      return [[link.name, "text"], link.traffic.is_open ? "open" : ["not open", "bad"],
        `${fixed(perSecond(link.frames, earlier?.frames), 0)} /s`, String(link.bad_crc + link.bad_bytes),
        String(link.lost_frames), `${fixed(perSecond(link.attitudes_sent, earlier?.attitudes_sent), 0)} Hz`];
    }));
  }

  // ---- the state as it comes ----
  function take(state) {
    if (before === null || state.now_s < (now?.now_s ?? 0)) {
      points.length = 0; // another run of the daemon
    }
    if (before === null || state.now_s - before.now_s >= 2 || state.now_s < before.now_s) before = now ?? state;
    now = state;
    const estimate = published(now)?.estimate, verdict = now.verdict;
    const isFresh = verdict && now.now_s - verdict.received_s < OLD_S;
    points.push({
      t: now.now_s, tilt: isFresh ? verdict.tilt_deg : null,
      heading: isFresh && verdict.heading_deg !== null ? Math.abs(verdict.heading_deg) : null,
      tiltSigma: estimate?.tilt_sigma_deg ?? null, headingSigma: estimate?.heading_sigma_deg ?? null,
    });
    while (points.length > MAX_POINTS || now.now_s - points[0].t > LONGEST_S) points.shift();
    const shownS = now.now_s - Math.min(points[0].t, now.spans[0]?.begin_s ?? now.now_s);
    spanS = [60, 120, 300, LONGEST_S].find((one) => one >= shownS) || LONGEST_S;
  }
  function showVerdict() {
    const verdict = now.verdict, words = { agree: "The autopilot's attitude agrees", disagree: "THE AUTOPILOT'S ATTITUDE IS WRONG",
      undecided: "Undecided" };
    byId("verdict").className = verdict?.agreement || "undecided";
    const difference = verdict && verdict.tilt_deg !== null ?
      `: tilt ${fixed(verdict.tilt_deg, 2)}°, heading ${fixed(verdict.heading_deg, 2, "+")}°` : "";
    put("verdict", !verdict ? "no verdict yet" :
      `${words[verdict.agreement]}${verdict.reason === "agrees" ? "" : ` (${verdict.reason})`}${difference}, ` +
      `for ${fixed(now.now_s - verdict.since_s, 0)} s`);
    const remarks = [...now.ailments, ...(now.ailments.length ? [] : now.obstacles), ...now.frame_notes, ...now.link_remarks];
    if (now.withheld) remarks.unshift(`attitude withheld: ${now.withheld}`);
    if (now.self_report.length) remarks.push(`the autopilot itself ${now.self_report.join(", ")}`);
    put("remarks", remarks.join("\n"));
    const vehicle = now.vehicle;
    put("vehicle", !vehicle ? "no vehicle" :
      `system ${vehicle.system}, ${vehicle.armed ? "armed" : "disarmed"}${vehicle.is_present ? "" : ", not heard"}, ${now.state}`);
  }
  function draw() {
    if (now === null) return;
    const estimate = published(now)?.estimate ?? null;
    showVerdict();
    showAttitude("ours", estimate, colours.ours, estimate ?
      `${estimate.filter}, sigma ${fixed(estimate.tilt_sigma_deg, 2)}°, heading ${estimate.north}` : "");
    showAttitude("theirs", now.autopilot, colours.autopilot, now.autopilot?.source || "");
    drawBand();
    const limit = now.tilt_threshold_deg;
    drawChart("tilt", "tilt", "tiltSigma", limit);
    drawChart("heading", "heading", "headingSigma", limit === null ? null : 2 * limit);
    showTables();
  }

  // ---- connection ----
  function showConnection() {
    const silence = performance.now() - heardMs, isLive = heardMs > 0 && silence < SILENT_MS;
    document.body.classList.toggle("stale", !isLive);
    byId("connection").className = isLive ? "" : "lost";
    put("connection", isLive ? "live" : heardMs === 0 ? "connecting to the daemon" :
      `the daemon is gone: nothing for ${fixed(silence / 1000, 0)} s, shown is the last state`);
  }
  function listen() {
    const source = new EventSource("/events");
    source.onmessage = (message) => {
      heardMs = performance.now();
      take(JSON.parse(message.data));
      showConnection();
      if (!document.hidden) requestAnimationFrame(draw);
    };
    source.onerror = () => {
      if (source.readyState !== EventSource.CLOSED) return; // the browser asks again by itself
      source.close();
      setTimeout(listen, 2000);
    };
  }
  readColours();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); draw(); });
  addEventListener("resize", draw);
  setInterval(showConnection, 500);
  listen();
})();
