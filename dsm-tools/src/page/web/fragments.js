// Fragments with coverage masks, and media between them: the light left in 64 places of a pixel.

/** The light in the places of one pixel. */
class Places {
  constructor(channels) {
    this.light = Array.from({ length: channels }, () => new Float64Array(64));
  }

  clear() {
    for (const light of this.light) light.fill(1);
  }

  /** Takes the opacity of a fragment from the places that it covers. */
  cover(low, high, opacity, row) {
    for (let channel = 0; channel < this.light.length; channel++) {
      const light = this.light[channel];
      const left = 1 - opacity[channel][row];
      for (let bits = low, place = 0; bits !== 0; bits >>>= 1, place++) if (bits & 1) light[place] *= left;
      for (let bits = high, place = 32; bits !== 0; bits >>>= 1, place++) if (bits & 1) light[place] *= left;
    }
  }

  mean(channel) {
    let sum = 0;
    for (const light of this.light[channel]) sum += light;
    return sum / 64;
  }
}

/** The field of fragments alone: a row each. */
function fragmentField(level) {
  if (column(level, "to depth")) return mediaField(level);
  const depth = column(level, "depth").values[0];
  const opacity = column(level, "opacity").values;
  const [low, high] = column(level, "mask").values;
  const before = opacity.map(() => new Float32Array(depth.length));
  const after = opacity.map(() => new Float32Array(depth.length));
  const places = new Places(opacity.length);
  for (let pixel = 0; pixel + 1 < level.lists.length; pixel++) {
    places.clear();
    const first = level.lists[pixel];
    for (let row = first; row < level.lists[pixel + 1]; row++) {
      const isDark = row > first && after.every((values) => values[row - 1] === 0);
      if (!isDark) places.cover(low[row], high[row], opacity, row);
      for (let channel = 0; channel < opacity.length; channel++) {
        before[channel][row] = row > first ? after[channel][row - 1] : 1;
        after[channel][row] = isDark ? 0 : places.mean(channel);
      }
    }
  }
  return new Field(level.width, level.height, level.lists, depth, before, after, "flat");
}

/**
 * The field of fragments and slabs: a row at every fragment and at both borders of every slab. Within a
 * slab light falls exponentially, so that it does between any two rows.
 */
function mediaField(level) {
  const near = column(level, "depth").values[0];
  const far = column(level, "to depth").values[0];
  const opacity = column(level, "opacity").values;
  const [low, high] = column(level, "mask").values;
  const channels = opacity.length;
  const pixels = level.width * level.height;
  const starts = new Uint32Array(pixels + 1);
  const depths = [], before = opacity.map(() => []), after = opacity.map(() => []);
  const places = new Places(channels);
  for (let pixel = 0; pixel < pixels; pixel++) {
    places.clear();
    const borders = new Set();
    const slabs = [], fragments = [];
    for (let row = level.lists[pixel]; row < level.lists[pixel + 1]; row++) {
      borders.add(near[row]);
      if (far[row] > near[row]) {
        borders.add(far[row]);
        slabs.push(row);
      } else {
        fragments.push(row);
      }
    }
    // What slabs let through up to a depth.
    const through = (depth, channel) => {
      let thickness = 0;
      for (const row of slabs) {
        const share = Math.min(Math.max((depth - near[row]) / (far[row] - near[row]), 0), 1);
        if (share > 0) thickness -= share * Math.log1p(-opacity[channel][row]);
      }
      return Math.exp(-thickness);
    };
    let next = 0;
    for (const depth of [...borders].sort((a, b) => a - b)) {
      depths.push(depth);
      const media = opacity.map((_, channel) => through(depth, channel));
      media.forEach((light, channel) => before[channel].push(places.mean(channel) * light));
      for (; next < fragments.length && near[fragments[next]] <= depth; next++) {
        places.cover(low[fragments[next]], high[fragments[next]], opacity, fragments[next]);
      }
      media.forEach((light, channel) => after[channel].push(places.mean(channel) * light));
    }
    starts[pixel + 1] = depths.length;
  }
  const columns = (lists) => lists.map((list) => Float32Array.from(list));
  return new Field(level.width, level.height, starts, Float32Array.from(depths), columns(before), columns(after), "exponential");
}
