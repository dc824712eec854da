// Image of the present scene and charts on one canvas, with labels.

import { digits, quantity } from "./si.js";
import { theme } from "./theme.js";

const EDGE = 24;
const LEGEND = 190;

/** The settings in one line. */
export function settingsLine(state) {
  const mass = state.mass_kg === null ? "wall" : `M = ${quantity(state.mass_kg * 1000, "g")}`;
  return [
    `K = ${digits(state.stiffness_n_per_m, 4)} N/m`,
    mass,
    `virtual force ${digits(state.virtual_force_n, 4)} N`,
    `${digits(1 / state.period_s, 4)} Hz`,
    ...state.lanes.map(({ method, damping_n_s_per_m: b }) => (b === null ? method : `${method} with b = ${digits(b)} N s/m`)),
  ].join(" · ");
}

/** Draws everything; the canvas is as fine as the screen. */
export function picture(model, view, scene, charts) {
  const ratio = devicePixelRatio;
  const visible = charts.visible;
  const chartWidth = Math.max(0, ...visible.map(({ uplot }) => uplot.width));
  const chartsHeight = visible.reduce((sum, { uplot }) => sum + uplot.height + 22, 0);
  const head = 64;
  const width = 2 * EDGE + scene.width + EDGE + chartWidth + LEGEND;
  const height = head + Math.max(scene.height, chartsHeight) + EDGE;
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.fillStyle = theme.panel;
  context.fillRect(0, 0, width, height);
  context.textBaseline = "alphabetic";
  write(context, model.hello.title, EDGE, 28, `600 16px ${theme.font}`, theme.ink);
  const to = digits(view.toS, 5);
  const about = `${settingsLine(model.state)} · ${digits(view.fromS, 5)} to ${to} s`;
  write(context, about, EDGE, 48, `12px ${theme.font}`, theme.quiet);
  context.textAlign = "right";
  const version = `palpate ${model.hello.version}, ${new Date().toISOString().slice(0, 19)}Z`;
  write(context, version, width - EDGE, 28, `12px ${theme.font}`, theme.quiet);
  context.textAlign = "left";
  context.drawImage(scene.canvas, EDGE, head, scene.width, scene.height);
  const left = 2 * EDGE + scene.width;
  let top = head;
  for (const chart of visible) {
    const { uplot, what, prefix } = chart;
    const title = `${what.title}, ${prefix.sign}${what.unit}`;
    write(context, title, left, top + 12, `600 12px ${theme.font}`, theme.ink);
    top += 18;
    context.drawImage(uplot.ctx.canvas, left, top, uplot.width, uplot.height);
    drawLegend(context, model, chart, left + chartWidth + 12, top + 12);
    top += uplot.height + 4;
  }
  return canvas;
}

function drawLegend(context, model, { what, legend }, left, top) {
  let y = top;
  model.state.lanes.forEach(({ method }, lane) => {
    what.curves.forEach(({ name, dash }, curve) => {
      context.strokeStyle = theme.lanes[lane];
      context.lineWidth = 1.75;
      context.setLineDash(dash);
      context.beginPath();
      context.moveTo(left, y - 4);
      context.lineTo(left + 22, y - 4);
      context.stroke();
      context.setLineDash([]);
      const text = what.curves.length > 1 ? `${method}, ${name}` : method;
      write(context, text, left + 28, y, `11px ${theme.font}`, theme.ink, LEGEND - 76);
      context.textAlign = "right";
      write(context, legend.cells[lane][curve].textContent, left + LEGEND - 12, y, `11px ${theme.font}`, theme.ink);
      context.textAlign = "left";
      y += 14;
    });
  });
}

function write(context, text, x, y, font, colour, widest) {
  context.font = font;
  context.fillStyle = colour;
  context.fillText(text, x, y, widest);
}
