// The charts: what each shows, in which unit, and how its lines look.

const SOLID = [];
const DASHED = [6, 4];
const DOTTED = [1.5, 3];
const BOTH = [7, 3, 1.5, 3];

/** What tells the curves of one chart from each other. */
export const DASHES = [SOLID, DASHED, DOTTED, BOTH];

/** `least`: the smallest range of the axis, so that rounding errors do not look like something. */
export const CHARTS = [
  {
    id: "position",
    chip: "Position",
    title: "Position",
    unit: "m",
    range: { least: 0.01, zero: false },
    curves: [
      { column: "device_position_m", name: "device", dash: SOLID },
      { column: "object_position_m", name: "object", dash: DASHED },
    ],
  },
  {
    id: "force",
    chip: "Force",
    title: "Force on the device",
    unit: "N",
    range: { least: 0.1 },
    curves: [{ column: "force_on_device_n", name: "sent", dash: SOLID }],
  },
  {
    id: "penetration",
    chip: "Penetration",
    title: "Penetration",
    unit: "m",
    range: { least: 1e-4, below: 0.25 },
    curves: [{ column: "penetration_m", name: "depth", dash: SOLID }],
  },
  {
    id: "energy",
    chip: "Energy",
    title: "Energy",
    unit: "J",
    range: { least: 1e-4 },
    curves: [
      { column: "stored_energy_j", name: "stored", dash: SOLID },
      { column: "port_work_j", name: "port work", dash: DASHED },
      { column: "virtual_force_work_j", name: "virtual force", dash: DOTTED },
      { column: "outside_work_j", name: "changes", dash: BOTH },
    ],
  },
  {
    id: "leak",
    chip: "Created",
    title: "Energy created",
    unit: "J",
    range: { least: 1e-5 },
    curves: [
      { column: "leak_held_j", name: "held force", dash: SOLID },
      { column: "leak_original_j", name: "plain spring", dash: DOTTED },
    ],
  },
  {
    id: "timing",
    chip: "Timing",
    title: "Timing",
    unit: "s",
    range: { least: 1e-5 },
    curves: [
      { column: "lateness_s", name: "woken late", dash: SOLID },
      { column: "tick_duration_s", name: "tick duration", dash: DOTTED },
    ],
  },
];
