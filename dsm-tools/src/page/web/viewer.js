// The page's state, its controls and what they change.

const $ = (id) => document.getElementById(id);
const page = JSON.parse($("page-data").textContent);
const state = { level: 0, pixel: [0, 0], pins: [], zoom: 1, run: 0, axis: new DepthAxis(0, 1, false), playing: 0 };
const isPair = page.maps.length === 2;
const PIXEL_STYLES = DASHES.map((dash, index) => ({ colour: `var(--c${index})`, dash }));
let panels = [], curve, cameraView, panelOfDifference, settle;

/** The slider's depth, a 32-bit float as those of the file. */
const depth = () => Math.fround(state.axis.depth(Number($("depth").value) / 1000));
const levelsOf = (index) => page.maps.map((map) => map.levels[index]);
const pixelIndex = ([x, y]) => y * levelsOf(state.level)[0].width + x;
/** The number of the chosen level in the file. */
const levelNumber = () => levelsOf(state.level)[0].index;
/** The pixel in the whole level, of one that is shown. */
const wholePixel = ([x, y]) => levelsOf(state.level)[0].corner.map((corner, axis) => corner + [x, y][axis]);

/**
 * The depths between which rows of these levels lie, for a slider: without the few far from all others, and
 * those behind the camera, that planes seen edge on have at a pixel's centre.
 */
function depthRange(levels) {
  const depths = [];
  let first = Infinity, last = 0;
  for (const level of levels) {
    for (const name of ["depth", "to depth"]) {
      const found = column(level, name)?.values[0] ?? [];
      const step = Math.max(1, Math.floor(found.length / 50000));
      for (let row = 0; row < found.length; row++) {
        const value = found[row];
        // Where the file's greatest number stands for infinity, it is no place on a slider.
        if (!(value > 0 && value < 3e38)) continue;
        if (value < first) first = value;
        if (value > last) last = value;
        if (row % step === 0) depths.push(value);
      }
    }
  }
  if (!(last > 0)) return [0, 1];
  depths.push(first, last);
  depths.sort((a, b) => a - b);
  const [low, high] = [0.002, 0.998].map((share) => depths[Math.round(share * (depths.length - 1))]);
  const reach = Math.max(high - low, 1e-6 * high);
  return [Math.max(first, low - reach), Math.min(last, high + reach)];
}

/** Fields of the chosen level of each map, made when they are first asked for. */
function fields() {
  return page.maps.map((map) => {
    const level = map.levels[state.level];
    level.fields ??= [];
    return (level.fields[state.run] ??= fieldOf(map.summary.kind, level, state.run));
  });
}

/** Values that are painted and counted: a column a map. */
function values(channel) {
  const levels = levelsOf(state.level);
  const show = $("show").value;
  if (show === "counts") return levels.map((level) => (level.counts ??= rowCounts(level)));
  if (show === "max" || show === "mean") return levels.map((level) => (level[`tiles_${show}`] ??= ofTiles(level, show === "max" ? 2 : 3)));
  return fields().map((field, map) => {
    const channels = channel < 0 ? [...Array(field.channels).keys()] : [Math.min(channel, field.channels - 1)];
    const level = levels[map];
    level.slices ??= [];
    const slices = channels.map((index) => {
      const out = (level.slices[index] ??= new Float32Array(level.width * level.height));
      field.slice(depth(), index, out);
      return out;
    });
    level.shown = slices;
    return slices.length === 1 ? slices[0] : mean(slices, (level.mean ??= new Float32Array(level.width * level.height)));
  });
}

/** Paints the maps at the depth: all that a step of the slider has to do at once. */
function paintMaps() {
  const show = $("show").value;
  const channel = Number($("channel").value);
  const columns = values(channel);
  const isLight = show === "light";
  const palette = $("palette").value;
  const top = isLight ? 1 : largest(columns);
  const scale = isLight ? new Scale(PALETTES[palette], 0, 1) : new Scale(PALETTES.ordered, 0, top, show === "counts");
  page.maps.forEach((map, index) => {
    const slices = map.levels[state.level].shown;
    if (isLight && channel < 0 && slices.length === 3 && palette !== "ordered") paintColours(panels[index].words, slices, palette === "grey");
    else paint(panels[index].words, columns[index], scale);
    panels[index].show();
  });
  if (panelOfDifference) {
    const difference = (state.difference ??= new Float32Array(columns[0].length));
    for (let pixel = 0; pixel < difference.length; pixel++) difference[pixel] = columns[0][pixel] - columns[1][pixel];
    // The same colours at every depth: as far as the two are ever apart.
    const reach = (isLight ? page.difference.max : top) || 1;
    state.reach = reach;
    paint(panelOfDifference.words, difference, new Scale(PALETTES.difference, -reach, reach));
    panelOfDifference.caption.textContent = `A − B: dark blue ${short(-reach)}, grey 0, light orange ${short(reach)}`;
    panelOfDifference.show();
  }
  $("depth-value").value = short(depth());
  $("depth-value").title = shortest(depth());
  curve?.setDepth(depth());
  clearTimeout(settle);
  settle = setTimeout(() => describe(columns, scale), state.playing ? 250 : 30);
}

/** What follows once the slider rests: legend, histogram, camera. */
function describe(columns, scale) {
  const bar = $("legend-bar").getContext("2d");
  const image = bar.createImageData(256, 1);
  const words = new Uint32Array(image.data.buffer);
  for (let at = 0; at < 256; at++) words[at] = scale.palette[Math.round((at / 255) * (PALETTE_SIZE - 1))];
  bar.putImageData(image, 0, 0);
  $("legend-low").textContent = short(scale.low);
  $("legend-high").textContent = `${short(scale.high)}${scale.isLog ? " (logarithmic)" : ""}`;
  const shown = panelOfDifference ? state.difference : columns[0];
  drawHistogram($("histogram"), $("histogram-text"), shown, panelOfDifference ? -state.reach : scale.low, panelOfDifference ? state.reach : scale.high);
  drawCamera();
  showValue();
}

function drawCamera() {
  const map = page.maps[0];
  const level = levelsOf(state.level)[0];
  const finest = map.summary;
  const isDeep = finest.kind === "deep" || level.index === 0;
  const whole = wholePixel(state.pixel);
  const scale = [finest.width / level.full_width, finest.height / level.full_height];
  cameraView?.draw(depth(), isDeep ? whole.map((value, axis) => (value + 0.5) * scale[axis] - 0.5) : null);
}

function showValue() {
  const at = pixelIndex(state.pixel);
  const parts = fields().map((field, map) => {
    const light = field.after.map((_, channel) => shortest(Math.fround(field.at(at, depth(), channel))));
    return `${isPair ? `${page.maps[map].name}: ` : ""}${light.join(", ")}`;
  });
  const what = page.maps[0].summary.kind === "attenuation" ? "The layer that was passed last sees of the light" : "Light left";
  $("pixel-value").textContent = `${what} at depth ${short(depth())}: ${parts.join("; ")}`;
}

/** Draws what belongs to the chosen pixel. */
function showPixel() {
  const whole = wholePixel(state.pixel);
  $("pixel-title").textContent = `Pixel (${whole.join(", ")})${levelNumber() > 0 ? ` of ${page.levelName} ${levelNumber()}` : ""}`;
  const pins = state.pins.filter((pin) => pin.level === state.level);
  const chosen = { pixel: state.pixel, label: "" };
  const curves = [];
  for (const [order, { pixel, label }] of [chosen, ...pins].entries()) {
    fields().forEach((field, map) => {
      const channel = Number($("channel").value);
      const channels = channel < 0 ? [...Array(field.channels).keys()] : [Math.min(channel, field.channels - 1)];
      for (const index of channels) {
        const style = PIXEL_STYLES[(channels.length > 1 || isPair ? curves.length : order) % PIXEL_STYLES.length];
        const colour = channels.length > 1 ? ["red", "green", "blue"][index] : "";
        const name = [label || `(${wholePixel(pixel).join(", ")})`, isPair ? "AB"[map] : "", colour].filter(Boolean).join(" ");
        curves.push({ name, style, field, pixel: pixelIndex(pixel), channel: index });
      }
    });
  }
  curve.draw(curves, new DepthAxis(...state.range, $("log").checked), depth());
  const marks = [[...state.pixel, ""], ...pins.map((pin) => [...pin.pixel, pin.label])];
  for (const panel of [...panels, panelOfDifference]) panel?.mark(marks);
  $("tables").replaceChildren();
  page.maps.forEach((map) => pixelTables($("tables"), map.name, map.levels[state.level], pixelIndex(state.pixel)));
  showPins();
  showValue();
  drawCamera();
}

function showPins() {
  $("pins").replaceChildren();
  state.pins.forEach((pin) => {
    const item = make("li", $("pins"), `${pin.label}: (${pin.whole.join(", ")})${pin.number > 0 ? `, ${page.levelName} ${pin.number}` : ""}`);
    const remove = make("button", item, "Remove", { type: "button", "aria-label": `Remove pin ${pin.label}` });
    remove.addEventListener("click", () => {
      state.pins = state.pins.filter((other) => other !== pin);
      showPixel();
    });
  });
}

function pin() {
  const used = new Set(state.pins.map((pin) => pin.label));
  const label = [..."PQRSTUVW"].find((letter) => !used.has(letter));
  if (label) state.pins.push({ label, level: state.level, number: levelNumber(), pixel: [...state.pixel], whole: wholePixel(state.pixel) });
  showPixel();
}

function choose(pixel) {
  state.pixel = pixel;
  showPixel();
}

/** Takes another level, run or scale of depths. */
function reset() {
  const before = state.axis && Number($("depth").value) === 1000 ? null : depth();
  const levels = levelsOf(state.level);
  const [{ width, height }] = levels;
  state.range = depthRange(levels);
  state.axis = new DepthAxis(...state.range, $("log").checked);
  if (before !== null) $("depth").value = Math.round(1000 * state.axis.place(before));
  state.pixel = [Math.min(state.pixel[0], width - 1), Math.min(state.pixel[1], height - 1)];
  state.difference = undefined;
  for (const panel of [...panels, panelOfDifference]) panel?.resize(width, height);
  paintMaps();
  showPixel();
}

function zoom(factor) {
  state.zoom = Math.min(Math.max(state.zoom * factor, 1), 32);
  for (const panel of [...panels, panelOfDifference]) panel?.enlarge(state.zoom, state.pixel);
}

function play() {
  const slider = $("depth");
  state.playing = state.playing ? 0 : 1;
  $("play").textContent = state.playing ? "Pause" : "Play";
  $("play").setAttribute("aria-pressed", String(Boolean(state.playing)));
  const step = () => {
    if (!state.playing) return;
    slider.value = (Number(slider.value) + 4) % 1001;
    paintMaps();
    requestAnimationFrame(step);
  };
  if (state.playing) requestAnimationFrame(step);
}

function press(event) {
  const isMap = event.target.tagName === "CANVAS";
  const { width, height } = levelsOf(state.level)[0];
  const by = event.shiftKey ? 8 : 1;
  const move = { ArrowLeft: [-by, 0], ArrowRight: [by, 0], ArrowUp: [0, -by], ArrowDown: [0, by] }[event.key];
  const turn = { PageUp: -10, PageDown: 10 }[event.key];
  if (!isMap || event.ctrlKey || event.metaKey || event.altKey) return;
  if (move) choose([Math.min(Math.max(state.pixel[0] + move[0], 0), width - 1), Math.min(Math.max(state.pixel[1] + move[1], 0), height - 1)]);
  else if (turn) { $("depth").value = Number($("depth").value) + turn; paintMaps(); }
  else if (event.key === " ") play();
  else if (event.key.toLowerCase() === "p") pin();
  else if (event.key === "+" || event.key === "=") zoom(2);
  else if (event.key === "-") zoom(0.5);
  else return;
  event.preventDefault();
}
