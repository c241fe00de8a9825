// The light that is left behind every depth of every pixel, whatever the kind of map.

/** Rows [depth, light before, light behind] of each pixel, and how they are joined. */
class Field {
  /**
   * `after` and `before` have a column a channel. `joined`: "flat" (steps), "linear", or "exponential"
   * (through media) between rows.
   */
  constructor(width, height, starts, depths, before, after, joined) {
    Object.assign(this, { width, height, starts, depths, before, after, joined });
    this.cursor = starts.slice(0, -1);
    this.channels = after.length;
  }

  /** The light of a channel between rows `next` − 1 and `next`. */
  between(next, depth, channel) {
    const near = this.after[channel][next - 1];
    if (this.joined === "flat") return near;
    const far = this.before[channel][next];
    const share = (depth - this.depths[next - 1]) / (this.depths[next] - this.depths[next - 1]);
    if (!(share > 0) || near === far) return near;
    if (this.joined === "linear") return Math.fround(near + share * (far - near));
    return far > 0 ? near * Math.pow(far / near, share) : 0;
  }

  /** The light behind a depth. */
  at(pixel, depth, channel) {
    let low = this.starts[pixel], high = this.starts[pixel + 1];
    const [first, end] = [low, high];
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (this.depths[middle] <= depth) low = middle + 1;
      else high = middle;
    }
    if (low === first) return 1;
    return low === end ? this.after[channel][low - 1] : this.between(low, depth, channel);
  }

  /** The light behind a depth in all pixels. What was found for the depth before is where it begins. */
  slice(depth, channel, out) {
    const { starts, depths, cursor } = this;
    const after = this.after[channel];
    const flat = this.joined === "flat";
    for (let pixel = 0; pixel < cursor.length; pixel++) {
      const first = starts[pixel], end = starts[pixel + 1];
      let next = cursor[pixel];
      let steps = 0;
      while (next < end && depths[next] <= depth && steps < 8) { next++; steps++; }
      while (next > first && depths[next - 1] > depth && steps < 8) { next--; steps++; }
      if (steps === 8) {
        let low = first, high = end;
        while (low < high) {
          const middle = (low + high) >>> 1;
          if (depths[middle] <= depth) low = middle + 1;
          else high = middle;
        }
        next = low;
      }
      cursor[pixel] = next;
      out[pixel] = next === first ? 1 : flat || next === end ? after[next - 1] : this.between(next, depth, channel);
    }
  }
}

/** The rows of a pixel as [depth, before, behind], each light an array with a number a channel. */
function rowsOfPixel(field, pixel) {
  const rows = [];
  for (let row = field.starts[pixel]; row < field.starts[pixel + 1]; row++) {
    rows.push([field.depths[row], field.before.map((column) => column[row]), field.after.map((column) => column[row])]);
  }
  return rows;
}

/** The column of this name. */
function column(level, name) {
  return level.columns.find((column) => column.name === name);
}

/** The field of a deep map: its rows are those of the file. */
function deepField(level) {
  const [depth, before, behind] = ["depth", "V before", "V at and behind"].map((name) => column(level, name).values);
  return new Field(level.width, level.height, level.lists, depth[0], before, behind, "linear");
}

/** The field of the runs with this number, 0 for the first: where a pixel has fewer, all light. */
function runField(level, run) {
  const depth = column(level, "depth").values[0];
  const light = column(level, "V behind").values;
  const pixels = level.width * level.height;
  const starts = new Uint32Array(pixels + 1);
  const depths = [], before = light.map(() => []), after = light.map(() => []);
  for (let pixel = 0; pixel < pixels; pixel++) {
    const list = level.lists[pixel] + run;
    const end = list < level.lists[pixel + 1] ? level.rows[list + 1] : 0;
    for (let row = list < level.lists[pixel + 1] ? level.rows[list] : 0; row < end; row++) {
      const step = row + 1 < end && depth[row + 1] === depth[row] ? row + 1 : row;
      const first = row;
      depths.push(depth[row]);
      light.forEach((values, channel) => {
        before[channel].push(values[first]);
        after[channel].push(values[step]);
      });
      row = step;
    }
    starts[pixel + 1] = depths.length;
  }
  const columns = (lists) => lists.map((list) => Float32Array.from(list));
  return new Field(level.width, level.height, starts, Float32Array.from(depths), columns(before), columns(after), "linear");
}

/** The field of layers whose opacities take light, or which state the light that they see (`share`). */
function layerField(level, name, share) {
  const depth = column(level, "depth").values[0];
  const opacity = column(level, name).values;
  const before = opacity.map((values) => new Float32Array(values.length));
  const after = opacity.map((values) => new Float32Array(values.length));
  for (let pixel = 0; pixel + 1 < level.lists.length; pixel++) {
    for (let channel = 0; channel < opacity.length; channel++) {
      let left = 1;
      for (let row = level.lists[pixel]; row < level.lists[pixel + 1]; row++) {
        before[channel][row] = left;
        left = share ? opacity[channel][row] : left * (1 - opacity[channel][row]);
        after[channel][row] = left;
      }
    }
  }
  return new Field(level.width, level.height, level.lists, depth, before, after, "flat");
}

/** The field of one opaque surface a pixel. */
function surfaceField(level) {
  const depth = column(level, "depth").values[0];
  return new Field(level.width, level.height, level.lists, depth, [new Float32Array(depth.length).fill(1)], [new Float32Array(depth.length)], "flat");
}

/** The field of a level of any kind. */
function fieldOf(kind, level, run) {
  if (kind === "deep") return deepField(level);
  if (kind === "mtsm") return runField(level, run);
  if (kind === "fragments") return fragmentField(level);
  if (kind === "views") return surfaceField(level);
  if (kind === "attenuation") return layerField(level, "attenuation", true);
  return layerField(level, "opacity", false);
}
