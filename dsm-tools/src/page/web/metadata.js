// The header and what else the file says of itself, as tables.

/** Writes an object as rows of names and values. */
function metadataTable(parent, name, summary) {
  const table = make("table", parent);
  make("caption", table, name);
  const body = make("tbody", table);
  const add = (key, value) => {
    const row = make("tr", body);
    make("th", row, key, { scope: "row" });
    make("td", row, value);
  };
  for (const [key, value] of Object.entries(summary)) {
    if (key === "levels") continue;
    if (key === "attributes") {
      for (const [attribute, of] of Object.entries(value)) add(attribute, typeof of.value === "string" ? of.value : JSON.stringify(of.value));
    } else if (value !== null) {
      add(key.replaceAll("_", " "), typeof value === "object" ? JSON.stringify(value) : String(value));
    }
  }
  levelTable(parent, summary.levels);
}

function levelTable(parent, levels) {
  const table = make("table", parent);
  make("caption", table, "Levels");
  const names = ["width", "height", "tolerance", "max_error", "mean_error", "depth_error", "error_at_depth", "vertices", "bytes"];
  const head = make("tr", make("thead", table));
  for (const name of ["level", ...names]) make("th", head, name.replaceAll("_", " "), { scope: "col" });
  const body = make("tbody", table);
  levels.forEach((level, index) => {
    const row = make("tr", body);
    make("th", row, index, { scope: "row" });
    for (const name of names) make("td", row, level[name]);
  });
}

/** What is stored of a pixel: the file's own rows, list by list. */
function pixelTables(parent, name, level, pixel) {
  const [first, end] = [level.lists[pixel], level.lists[pixel + 1]];
  const lists = level.has_lists ? Array.from({ length: end - first }, (_, list) => [level.rows[first + list], level.rows[first + list + 1]]) : [[first, end]];
  const isEmpty = lists.every(([from, to]) => from === to);
  if (isEmpty) make("p", parent, `${name}: nothing is stored of this pixel`);
  for (const [index, [from, to]] of isEmpty ? [] : lists.entries()) {
    const table = make("table", parent);
    make("caption", table, level.has_lists ? `${name}, run ${index}` : name);
    const head = make("tr", make("thead", table));
    for (const column of level.columns) make("th", head, column.name, { scope: "col" });
    const body = make("tbody", table);
    for (let row = from; row < to; row++) {
      const line = make("tr", body);
      for (const column of level.columns) {
        const words = column.values.map((values) => values[row]);
        if (column.type === "mask") maskCell(line, words);
        else make("td", line, column.type === "count" ? String(words[0]) : words.map(shortest).join(" "));
      }
    }
  }
}

/** A coverage mask as it lies in its pixel: bit 0 is the upper left place. */
function maskCell(line, [low, high]) {
  const text = `0x${high.toString(16).padStart(8, "0")}${low.toString(16).padStart(8, "0")}`;
  const cell = make("td", line);
  const picture = make("div", cell, "", { class: "mask", role: "img", "aria-label": `mask ${text}`, title: text });
  for (let place = 0; place < 64; place++) {
    make("i", picture, "", ((place < 32 ? low >>> place : high >>> (place - 32)) & 1) ? { class: "on" } : {});
  }
}
