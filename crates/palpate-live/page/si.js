// Numbers with SI prefixes, as people read them.

const PREFIXES = [
  { factor: 1e-12, sign: "p" },
  { factor: 1e-9, sign: "n" },
  { factor: 1e-6, sign: "µ" },
  { factor: 1e-3, sign: "m" },
  { factor: 1, sign: "" },
  { factor: 1e3, sign: "k" },
  { factor: 1e6, sign: "M" },
  { factor: 1e9, sign: "G" },
];

/** The prefix with which a number of this size reads best: 1 to 999 of it, or 0 of the unit itself. */
export function prefixFor(size) {
  const magnitude = Math.abs(size);
  if (!(magnitude > 0) || !Number.isFinite(magnitude)) {
    return PREFIXES[4];
  }
  let chosen = PREFIXES[0];
  for (const prefix of PREFIXES) {
    // 999.6 would be read as 1000 with three digits.
    if (magnitude >= prefix.factor * 0.9995) {
      chosen = prefix;
    }
  }
  return chosen;
}

/** A number with three digits that count, never as 1e-7, with a true minus. */
export function digits(value, count = 3) {
  if (Number.isNaN(value)) {
    return "–";
  }
  if (!Number.isFinite(value)) {
    return value > 0 ? "∞" : "−∞";
  }
  if (value === 0) {
    return "0";
  }
  const before = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(count))))) + 1;
  const decimals = Math.max(0, Math.min(count - Math.max(before, 1), 9));
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? `−${text}` : text;
}

/** How many decimals numbers need that are this far apart: 2 for 0.25. */
export function decimalsOf(step) {
  let decimals = 0;
  while (decimals < 9 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6 * step * 10 ** decimals) {
    decimals += 1;
  }
  return decimals;
}

/** A number with its unit and a fitting prefix: 0.00123 m is "1.23 mm". */
export function quantity(value, unit, count = 3) {
  const prefix = prefixFor(value);
  return `${digits(value / prefix.factor, count)} ${prefix.sign}${unit}`;
}

/** A number of bytes. */
export function bytes(count) {
  if (count < 1000) {
    return `${count} B`;
  }
  return quantity(count, "B");
}

/** A duration in whole units that a person counts in: "34 s", "2 min 5 s". */
export function duration(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return whole < 120 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

/** A number as one would write it. */
export function plain(value) {
  return String(Number(value.toPrecision(6))).replace("-", "−");
}
