// Colours and fonts for canvas drawings, from the style sheet: only it selects light or dark.

const NAMES = ["paper", "panel", "ink", "quiet", "rule", "grid", "solid", "fixed", "alarm", "lane-1", "lane-2"];

export const theme = { lanes: [] };

/** Reads the colours anew. */
export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) {
    theme[name] = style.getPropertyValue(`--${name}`).trim();
  }
  theme.lanes = [theme["lane-1"], theme["lane-2"]];
  theme.font = getComputedStyle(document.body).fontFamily;
}

/** Calls back when light becomes dark, or the other way round. */
export function onThemeChange(callback) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readTheme();
    callback();
  });
}
