// What a panel shows: light at a depth, differences, or false colours.

/** A palette, and the values at its ends. */
class Scale {
  constructor(palette, low, high, isLog = false) {
    Object.assign(this, { palette, low, high, isLog });
  }

  index(value) {
    const share = this.isLog ? Math.log1p(value - this.low) / Math.log1p(this.high - this.low || 1) : (value - this.low) / (this.high - this.low || 1);
    return paletteIndex(share);
  }
}

/** Fills a panel's words with a palette's colours of values. */
function paint(words, values, scale) {
  const { palette } = scale;
  if (scale.low === 0 && scale.high === 1 && !scale.isLog) {
    for (let pixel = 0; pixel < values.length; pixel++) {
      const value = values[pixel];
      words[pixel] = palette[value >= 1 ? PALETTE_SIZE - 1 : value > 0 ? (value * (PALETTE_SIZE - 1) + 0.5) | 0 : 0];
    }
    return;
  }
  for (let pixel = 0; pixel < values.length; pixel++) words[pixel] = palette[scale.index(values[pixel])];
}

/** Fills a panel's words with colours of three channels. */
function paintColours(words, [red, green, blue], isCurved) {
  const code = (value) => isCurved ? SRGB[paletteIndex(value)] : (paletteIndex(value) / (PALETTE_SIZE - 1)) * 255;
  for (let pixel = 0; pixel < red.length; pixel++) words[pixel] = rgba(code(red[pixel]), code(green[pixel]), code(blue[pixel]));
}

/** The means of columns. */
function mean(columns, out) {
  out.set(columns[0]);
  for (const column of columns.slice(1)) for (let at = 0; at < out.length; at++) out[at] += column[at];
  if (columns.length > 1) for (let at = 0; at < out.length; at++) out[at] /= columns.length;
  return out;
}

/** Rows of every pixel. */
function rowCounts(level) {
  const { lists, rows } = level;
  return Float32Array.from({ length: lists.length - 1 }, (_, pixel) => level.has_lists ? rows[lists[pixel + 1]] - rows[lists[pixel]] : lists[pixel + 1] - lists[pixel]);
}

/** A number of each pixel's tile: [column, row, max error, mean error]. */
function ofTiles(level, number) {
  const [tileWidth, tileHeight] = level.tile;
  const across = Math.ceil(level.full_width / tileWidth);
  const numbers = new Map(level.tiles.map((tile) => [tile[1] * across + tile[0], tile[number]]));
  const values = new Float32Array(level.width * level.height);
  for (let y = 0, pixel = 0; y < level.height; y++) {
    const row = Math.floor((y + level.corner[1]) / tileHeight) * across;
    for (let x = 0; x < level.width; x++, pixel++) values[pixel] = numbers.get(row + Math.floor((x + level.corner[0]) / tileWidth)) ?? 0;
  }
  return values;
}

function largest(columns) {
  let most = 0;
  for (const column of columns) for (const value of column) if (value > most) most = value;
  return most;
}
