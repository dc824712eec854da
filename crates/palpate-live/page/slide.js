// Position of a value on a slider from 0 to 1, logarithmic: every decade has the same length.

// Smallest value above 0 of a slider that begins at 0: this many decades below its other end.
const DECADES = 5;

/**
 * A scale between two limits. From a positive limit it is logarithmic. From 0 its lowest hundredth is 0, the rest
 * logarithmic. Across 0 it goes by the cube, fine in the middle.
 *
 * @param {number} low
 * @param {number} high
 * @returns {{place: (value: number) => number, value: (place: number) => number}}
 */
export function slide(low, high) {
  if (low > 0) {
    const ratio = Math.log(high / low);
    return {
      place: (value) => within(Math.log(value / low) / ratio),
      value: (place) => (place <= 0 ? low : place >= 1 ? high : rounded(low * Math.exp(place * ratio))),
    };
  }
  if (low === 0) {
    const notch = 0.01;
    const above = slide(high * 10 ** -DECADES, high);
    return {
      place: (value) => (value > 0 ? notch + (1 - notch) * above.place(value) : 0),
      value: (place) => (place < notch ? 0 : above.value((place - notch) / (1 - notch))),
    };
  }
  const size = Math.max(-low, high);
  const from = Math.cbrt(low / size);
  const to = Math.cbrt(high / size);
  return {
    place: (value) => within((Math.cbrt(value / size) - from) / (to - from)),
    value: (place) => {
      const root = from + place * (to - from);
      // 0 has to be found by hand.
      return Math.abs(root) < 0.06 ? 0 : place <= 0 ? low : place >= 1 ? high : rounded(size * root ** 3);
    },
  };
}

function within(place) {
  return Number.isNaN(place) ? 0 : Math.min(1, Math.max(0, place));
}

/** What a slider sets is a number that one would write. */
function rounded(value) {
  return Number(value.toPrecision(3));
}
