// Settings as one plain object; the presets are such objects.
//
// Settings that a preset leaves out have the values of `START`.

/** A block that rests on the device by its weight: the scene of `palpate live`. */
export const START = {
  methods: ["basic", "coupled"],
  damping_n_s_per_m: [null, null],
  stiffness_n_per_m: 600,
  mass_kg: 0.1,
  virtual_force_n: -0.981,
  period_s: 0.01,
  device_mass_kg: 0.25,
  delay_s: 0,
  cut_off: false,
  hand_m: 0,
};

export const PRESETS = [
  {
    id: "light",
    name: "Light cube, 50 Hz",
    about: "A 50 g cube on the device, at 50 Hz. The plain spring keeps creating energy: the cube never comes to rest.",
    settings: { mass_kg: 0.05, virtual_force_n: -0.4905, stiffness_n_per_m: 200, period_s: 0.02 },
  },
  {
    id: "late",
    name: "Late by 5 ms",
    about: "Forces begin 5 ms after their sample, at 500 Hz. The plain spring ignores it; coupled rendering models it.",
    settings: { mass_kg: 0.1, virtual_force_n: -0.981, period_s: 0.002, delay_s: 0.005, stiffness_n_per_m: 2000 },
  },
  {
    id: "wall",
    name: "Stiff wall, light device",
    about: "A wall of 6000 N/m at 100 Hz, pressed with a device of 50 g: the plain spring buzzes.",
    settings: {
      mass_kg: null,
      virtual_force_n: 0,
      stiffness_n_per_m: 6000,
      device_mass_kg: 0.05,
      hand_m: 0.035,
    },
  },
  {
    id: "fast",
    name: "Light cube, 1 kHz",
    about: "The same cube, rendered twenty times as often: the plain spring creates hardly any energy.",
    settings: { mass_kg: 0.05, virtual_force_n: -0.4905, stiffness_n_per_m: 200, period_s: 0.001 },
  },
];

/** Messages that give the loop these settings, in an order without dependencies on earlier settings. */
export function messagesOf(settings) {
  const { methods, damping_n_s_per_m: dampings, stiffness_n_per_m, mass_kg, virtual_force_n, period_s } = settings;
  const { device_mass_kg, delay_s, cut_off } = settings;
  const device = { type: "device", mass_kg: device_mass_kg, cut_off };
  return [
    // A delay may be too long for the previous period.
    { ...device, delay_s: 0 },
    {
      type: "set",
      stiffness_n_per_m,
      mass_kg,
      virtual_force_n,
      period_s,
      lanes: methods.map((method, lane) => ({ method, damping_n_s_per_m: dampings[lane] ?? null })),
    },
    ...(delay_s > 0 ? [{ ...device, delay_s }] : []),
  ];
}

/** Settings in a state of the loop. */
export function settingsOf(state) {
  const { stiffness_n_per_m, mass_kg, virtual_force_n, period_s, device, lanes, hand_m } = state;
  return {
    methods: lanes.map(({ method }) => method),
    damping_n_s_per_m: lanes.map(({ damping_n_s_per_m }) => damping_n_s_per_m),
    stiffness_n_per_m,
    mass_kg,
    virtual_force_n,
    period_s,
    device_mass_kg: device.mass_kg,
    delay_s: device.delay_s,
    cut_off: device.cut_off,
    hand_m,
  };
}
