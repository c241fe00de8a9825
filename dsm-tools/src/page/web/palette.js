// Colours of values, told apart without colour vision by how bright they are.

const PALETTE_SIZE = 1024;

/** An RGBA word as images have it, whatever the order of the processor's bytes. */
const rgba = (() => {
  const bytes = new Uint8Array(4);
  const word = new Uint32Array(bytes.buffer);
  return (red, green, blue) => {
    bytes.set([red, green, blue, 255]);
    return word[0];
  };
})();

/** The 8-bit sRGB code of a linear value in [0, 1]. */
function srgb(value) {
  const curved = value <= 0.0031308 ? 12.92 * value : 1.055 * Math.pow(value, 1 / 2.4) - 0.055;
  return Math.round(255 * curved);
}

/** A palette of colours at even distances, in a straight line between them. */
function ramp(colours) {
  return Uint32Array.from({ length: PALETTE_SIZE }, (_, index) => {
    const at = (index / (PALETTE_SIZE - 1)) * (colours.length - 1);
    const low = Math.min(Math.floor(at), colours.length - 2);
    const mixed = [0, 1, 2].map((c) => Math.round(colours[low][c] + (at - low) * (colours[low + 1][c] - colours[low][c])));
    return rgba(...mixed);
  });
}

const SRGB = Uint8Array.from({ length: PALETTE_SIZE }, (_, index) => srgb(index / (PALETTE_SIZE - 1)));
const PALETTES = {
  grey: Uint32Array.from(SRGB, (code) => rgba(code, code, code)),
  linear: ramp([[0, 0, 0], [255, 255, 255]]),
  ordered: ramp([[0, 20, 70], [52, 64, 107], [102, 105, 112], [150, 145, 120], [202, 190, 100], [255, 234, 70]]),
  // Darker below 0 in blue, brighter above in orange, grey in the middle: order by brightness alone.
  difference: ramp([[5, 48, 97], [67, 120, 180], [128, 128, 128], [253, 184, 99], [255, 245, 220]]),
};

/** The place of a value of [0, 1] in a palette. */
function paletteIndex(value) {
  return value >= 1 ? PALETTE_SIZE - 1 : value > 0 ? (value * (PALETTE_SIZE - 1) + 0.5) | 0 : 0;
}
