// Timing of the loop, losses, number of clients, and the recording.

import { bytes, digits, duration, quantity } from "./si.js";

// The rate is taken over this many reports, two a second.
const REPORTS = 5;

/**
 * The rate that a lane has really reached between two reports [Hz]: by the time of the loop's ticks, since reports wait on
 * their way. NaN where there is nothing to tell it by.
 */
export function rate(before, after, lane) {
  const ticks = (after?.lanes[lane]?.ticks ?? NaN) - (before?.lanes[lane]?.ticks ?? NaN);
  const passedS = (after?.lanes[lane]?.t_s ?? NaN) - (before?.lanes[lane]?.t_s ?? NaN);
  return ticks >= 0 && passedS > 0 ? ticks / passedS : NaN;
}

const COLUMNS = [
  { title: "Rate", about: "measured ticks per second", of: (_, r) => (r === r ? `${digits(r, 4)} Hz` : "–") },
  { title: "Late, 99 %", about: "99 of 100 ticks began no later than this", of: (lane) => seconds(lane.lateness_s?.p99) },
  { title: "Tick, 99 %", about: "99 of 100 ticks took no longer than this", of: (lane) => seconds(lane.tick_s?.p99) },
  { title: "Missed", about: "missed deadlines", of: (lane) => count(lane.missed_deadlines) },
  { title: "No sample", about: "ticks without a new sample of the device", of: (lane) => count(lane.without_sample) },
  { title: "Stop force", about: "zero-force commands of the supervisor because the loop did not answer", of: (lane) => count(lane.supervisor_cuts) },
  { title: "Not shown", about: "ticks dropped on the way to this page; recordings contain them", of: (lane) => count(lane.unsent) },
];

export class Status {
  /** @param {{table: HTMLTableElement, served: HTMLElement, recording: HTMLElement}} places */
  constructor(places, model) {
    this.places = places;
    this.model = model;
    this.reports = [];
    this.screenRate = NaN;
    const head = places.table.createTHead().insertRow();
    head.append(cell("td", ""), ...COLUMNS.map(({ title, about }) => cell("th", title, about)));
    this.body = places.table.createTBody();
  }

  /** Forgets earlier reports: the server has begun anew. */
  anew() {
    this.reports = [];
  }

  /** Takes a report. */
  take() {
    this.reports.push(this.model.status);
    this.reports.splice(0, this.reports.length - REPORTS);
    this.tell();
  }

  /** Shows a row for each lane, also before the first report: the scene above would lose its height to a row that comes. */
  tell() {
    const { model } = this;
    const rows = (model.state ?? model.status).lanes.map(({ method }, i) => {
      const lane = model.status?.lanes[i] ?? {};
      const row = document.createElement("tr");
      const name = cell("th", method ?? "");
      name.scope = "row";
      name.className = `lane-${i + 1}`;
      row.append(name, ...COLUMNS.map(({ of }) => cell("td", of(lane, rate(this.reports[0], model.status, i)))));
      return row;
    });
    this.body.replaceChildren(...rows);
    this.takeRecording();
    this.serve();
  }

  serve() {
    const { model, screenRate } = this;
    const parts = [
      // This page at least looks on.
      `${counted(model.status?.clients ?? 1, "page")} connected`,
      `${counted(model.droppedFrames, "frame")} dropped on the way here`,
      Number.isNaN(screenRate) ? "" : `${counted(Math.round(screenRate), "picture")} per second`,
    ];
    this.places.served.textContent = parts.filter(Boolean).join(" · ");
  }

  takeRecording() {
    const { state, status, recordedFiles } = this.model;
    const reported = status?.recording;
    let text = "";
    if (state?.recording) {
      const parts = [`Recording ${recordedFiles.join(", ")}`];
      if (reported) {
        parts.push(`${count(reported.ticks)} ticks`, `${count(reported.lost)} lost`, bytes(reported.bytes));
        this.lastRecording = reported;
      }
      text = parts.join(" · ");
    } else if (recordedFiles.length > 0) {
      const last = this.lastRecording;
      text = `Recorded ${recordedFiles.join(", ")}${last?.lost ? ` · ${count(last.lost)} ticks lost` : ""}`;
    }
    const failed = reported?.failed ?? null;
    const { recording } = this.places;
    const said = failed ? `Recording has failed: ${failed}` : text;
    if (recording.textContent !== said) {
      // Screen readers announce a failure once, and not every count.
      if (failed) {
        recording.setAttribute("role", "alert");
      } else {
        recording.removeAttribute("role");
      }
      recording.textContent = said;
    }
    recording.classList.toggle("refused", failed !== null);
  }
}

function cell(kind, text, about = "") {
  const made = document.createElement(kind);
  made.textContent = text;
  if (about) {
    made.title = about;
  }
  return made;
}

function seconds(value) {
  return value === undefined || value === null ? "–" : quantity(value, "s");
}

/** So many of something, by its name for one. */
export function counted(number, name) {
  return `${number} ${name}${number === 1 ? "" : "s"}`;
}

function count(value) {
  return value === undefined || value === null ? "–" : value.toLocaleString("en").replaceAll(",", "\u202f");
}

/** How much is in the buffer, and what a pause does to it. */
export function aboutBuffer(model, view) {
  if (!view.paused) {
    return "";
  }
  const since = Math.max(0, model.newestS - view.edgeS);
  const more = Number.isNaN(since) ? "" : `; ${duration(since)} more received since`;
  const full = model.refusedRows > 0 ? " The buffer is full: new data is discarded until you resume." : "";
  return `Paused at ${digits(view.edgeS, 4)} s${more}.${full} Drag across a chart to zoom, double-click to see all.`;
}
