// An artificial horizon.
import { colours, prepared } from "./elements.js";

export function drawHorizon(id, attitude, colour) {
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
