// Draws the state of the daemon as it comes, four times a second. Whatever is old is marked, and never shown as live.
import { drawBand, drawChart } from "./charts.js";
import { byId, colours, fixed, put, readColours } from "./elements.js";
import { drawHorizon } from "./horizon.js";
import { showTables } from "./tables.js";

const LONGEST_S = 600, OLD_S = 1.5, SILENT_MS = 3000, MAX_POINTS = 2400;
const points = [];
let now = null, before = null, heardMs = 0, spanS = 60;

const published = (state) => state.lanes.find((lane) => lane.estimate !== null);

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
  if (now.recording?.complaint) remarks.push(`nothing is recorded: ${now.recording.complaint}`);
  put("remarks", remarks.join("\n"));
  const vehicle = now.vehicle;
  put("vehicle", !vehicle ? "no vehicle" :
    `system ${vehicle.system}, ${vehicle.armed ? "armed" : "disarmed"}${vehicle.is_present ? "" : ", not heard"}, ${now.state}`);
}
function draw() {
  if (now === null) return;
  const estimate = published(now)?.estimate ?? null, view = { now, points, spanS };
  showVerdict();
  showAttitude("ours", estimate, colours.ours, estimate ?
    `${estimate.filter}, sigma ${fixed(estimate.tilt_sigma_deg, 2)}°, heading ${estimate.north}` : "");
  showAttitude("theirs", now.autopilot, colours.autopilot, now.autopilot?.source || "");
  drawBand(view);
  const limit = now.tilt_threshold_deg;
  drawChart(view, "tilt", "tilt", "tiltSigma", limit);
  drawChart(view, "heading", "heading", "headingSigma", limit === null ? null : 2 * limit);
  showTables(now, before);
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
