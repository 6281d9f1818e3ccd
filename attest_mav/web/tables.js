// Tables of the page.
import { byId, fixed, size } from "./elements.js";

const UNFIT = ["inflated", "outside_gate", "implausible", "too_old"]; // uses of a measurement that did not fit

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
// now, before: the state, and one some seconds earlier, from whose counters the rates are.
export function showTables(now, before) {
  const perSecond = (count, earlier) =>
    before === null || earlier === undefined || now.now_s <= before.now_s ? null
      : Math.max(0, (count - earlier) / (now.now_s - before.now_s));
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
      lane.estimate ? "published" : "used, not published";
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
