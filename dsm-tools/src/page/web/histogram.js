// How many pixels have which value.

const BINS = 40;

/** Draws the numbers of values in even parts of [low, high]. */
function drawHistogram(parent, text, values, low, high) {
  const counts = new Array(BINS).fill(0);
  let sum = 0, least = Infinity, most = -Infinity;
  for (const value of values) {
    counts[Math.min(Math.max(Math.floor(((value - low) / (high - low || 1)) * BINS), 0), BINS - 1)]++;
    sum += value;
    if (value < least) least = value;
    if (value > most) most = value;
  }
  const mean = sum / (values.length || 1);
  parent.replaceChildren();
  const svg = make("svg", parent, "", { viewBox: "0 0 640 170", role: "img" });
  make("title", svg, `Histogram of ${values.length} values from ${short(low)} to ${short(high)}`);
  // Few pixels are to be seen beside very many: heights are square roots.
  const highest = Math.sqrt(Math.max(...counts, 1));
  counts.forEach((count, bin) => {
    const height = (130 * Math.sqrt(count)) / highest;
    const bar = make("rect", svg, "", { x: 10 + bin * 15.5, y: 140 - height, width: 14, height, fill: "var(--accent)" });
    make("title", bar, `${short(low + (bin / BINS) * (high - low))} to ${short(low + ((bin + 1) / BINS) * (high - low))}: ${count} pixels`);
  });
  make("path", svg, "", { class: "axis", d: "M10 140H630" });
  make("text", svg, short(low), { x: 10, y: 158 });
  make("text", svg, short(high), { x: 630, y: 158, "text-anchor": "end" });
  make("text", svg, "pixels, heights as square roots", { x: 320, y: 158, "text-anchor": "middle" });
  text.textContent = `${values.length} pixels: least ${short(least)}, mean ${short(mean)}, largest ${short(most)}`;
}

/** A number with five digits at most. */
function short(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(5))) : String(value);
}
