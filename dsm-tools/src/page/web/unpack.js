// What the page holds: JSON, and each level's numbers as byte planes in one zlib stream.

/** The bytes of a zlib stream in base64. */
async function inflate(text) {
  const packed = atob(text.trim());
  const bytes = new Uint8Array(packed.length);
  for (let at = 0; at < packed.length; at++) bytes[at] = packed.charCodeAt(at);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Takes columns of 32-bit words from byte planes: the lowest bytes of all words first. */
class PlaneReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  words(count) {
    const words = new Uint32Array(count);
    for (let plane = 0; plane < 4; plane++) {
      const shift = 8 * plane;
      const from = this.at + plane * count;
      for (let index = 0; index < count; index++) words[index] |= this.bytes[from + index] << shift;
    }
    this.at += 4 * count;
    if (this.at > this.bytes.length) throw new Error("the page's columns are shorter than it states");
    return words;
  }
}

/** Where lists begin, and the end of the last, from their lengths. */
function startsOf(lengths) {
  const starts = new Uint32Array(lengths.length + 1);
  for (let index = 0; index < lengths.length; index++) starts[index + 1] = starts[index] + lengths[index];
  return starts;
}

/**
 * The numbers of a level as the file has them: where each pixel's lists begin, where each list's rows
 * begin, and a column of bits for each number of a row.
 */
async function unpackLevel(level) {
  const element = document.getElementById(level.columns_id);
  const reader = new PlaneReader(await inflate(element.textContent));
  element.remove();
  const lists = startsOf(reader.words(level.width * level.height));
  // Where there are no several lists, a pixel has one.
  const rows = level.has_lists ? startsOf(reader.words(lists[lists.length - 1])) : lists;
  const count = rows[rows.length - 1];
  const columns = level.columns.map((column) => ({
    ...column,
    bits: Array.from({ length: column.words }, () => reader.words(count)),
  }));
  // Each word stands as its difference from that of a column of the row before.
  for (let row = 1; row < count; row++) {
    for (let index = columns.length - 1; index >= 0; index--) {
      const { bits, before } = columns[index];
      const previous = columns[before].bits;
      for (let word = 0; word < bits.length; word++) bits[word][row] ^= previous[word][row - 1];
    }
  }
  for (const column of columns) {
    column.values = column.type === "light" || column.type === "number"
      ? column.bits.map((bits) => new Float32Array(bits.buffer))
      : column.bits;
  }
  return { ...level, lists, rows, columns, has_lists: level.has_lists };
}

/** The shortest decimal number that is this 32-bit float. */
function shortest(value) {
  if (!Number.isFinite(value)) return String(value);
  for (let digits = 1; digits <= 9; digits++) {
    const text = value.toPrecision(digits);
    if (Math.fround(Number(text)) === value) return String(Number(text));
  }
  return String(value);
}
