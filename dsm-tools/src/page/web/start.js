// Unpacks the maps and puts the page together.

function options(select, label, entries) {
  for (const [value, text] of entries) make("option", select, text, { value });
  if (label && entries.length < 2) label.hidden = true;
}

/** Words for a map under its picture. */
function captionOf(map, index) {
  return `${isPair ? `${"AB"[index]}: ` : ""}${map.name}`;
}

function facts() {
  const { summary } = page.maps[0];
  const levels = summary.levels.length;
  const said = [`kind ${summary.kind}`, `${summary.width} × ${summary.height} pixels`, summary.channels === 1 ? "mono" : "RGB", `${levels} ${levels === 1 ? "level" : summary.kind === "views" ? "views" : "levels"}`, `tolerance ${summary.tolerance}`];
  if (page.difference) {
    const { max, mean: average, worst } = page.difference;
    said.push(worst ? `largest difference ${short(max)} at pixel (${worst.x}, ${worst.y}) of level ${worst.level}, depth ${shortest(worst.z)}; mean ${short(average)}` : "no difference");
  }
  return said.join(" · ");
}

function fill() {
  const first = page.maps[0];
  const kind = first.summary.kind;
  const rows = { deep: "Vertices", mtsm: "Layers", views: "Surfaces", fragments: "Fragments", prefiltered: "Fragments" }[kind] ?? "Layers";
  const shows = [["light", kind === "attenuation" ? "Light seen by the last layer passed" : "Light left at the depth"], ["counts", `${rows} a pixel`], ["max", "Stated largest error of a tile"], ["mean", "Stated mean error of a tile"]];
  options($("show"), null, shows);
  page.levelName = kind === "views" ? "view" : "level";
  $("level-label").firstChild.textContent = kind === "views" ? "View " : "Level ";
  const both = first.levels.map((level, index) => [index, `${level.index}: ${level.full_width} × ${level.full_height}`]);
  options($("level"), $("level-label"), both);
  const colours = [[-1, "colour"], [0, "red"], [1, "green"], [2, "blue"]];
  options($("channel"), $("channel-label"), first.summary.channels === 3 ? colours : [[0, "light"]]);
  const level = first.levels[0];
  const runs = level.has_lists ? largest([Float32Array.from({ length: level.lists.length - 1 }, (_, pixel) => level.lists[pixel + 1] - level.lists[pixel])]) : 1;
  options($("run"), $("run-label"), Array.from({ length: Math.max(runs, 1) }, (_, run) => [run, run]));
}

function listen() {
  $("depth").addEventListener("input", paintMaps);
  $("play").addEventListener("click", play);
  $("pin").addEventListener("click", pin);
  $("closer").addEventListener("click", () => zoom(2));
  $("farther").addEventListener("click", () => zoom(0.5));
  $("log").addEventListener("change", reset);
  $("palette").addEventListener("change", paintMaps);
  for (const id of ["show", "channel"]) $(id).addEventListener("change", () => { paintMaps(); showPixel(); });
  $("level").addEventListener("change", () => { state.level = Number($("level").value); reset(); });
  $("run").addEventListener("change", () => { state.run = Number($("run").value); reset(); });
  $("panels").addEventListener("keydown", press);
}

async function start() {
  $("facts").textContent = facts();
  for (const note of page.notes) make("li", $("notes"), note);
  for (const map of page.maps) map.levels = await Promise.all(map.levels.map(unpackLevel));
  fill();
  page.maps.forEach((map, index) => {
    panels.push(new Panel($("panels"), captionOf(map, index), `Map ${map.name}, light at the depth`, choose));
    metadataTable($("metadata"), captionOf(map, index), map.summary);
  });
  if (isPair) panelOfDifference = new Panel($("panels"), "A − B", "Difference of the maps", choose);
  curve = new CurvePlot($("curve"), $("readout"));
  const { summary } = page.maps[0];
  if (summary.camera?.world_to_camera && summary.camera.world_to_ndc) {
    cameraView = new CameraView($("camera"), $("camera-text"), summary, depthRange(page.maps[0].levels));
  } else {
    $("camera-text").textContent = "The map does not say where its camera stands.";
  }
  const { width, height } = levelsOf(0)[0];
  state.pixel = [width >> 1, height >> 1];
  // What is hidden has no size.
  for (const id of ["controls", "columns"]) $(id).hidden = false;
  $("loading").hidden = true;
  listen();
  $("depth").value = 500;
  state.axis = new DepthAxis(...depthRange(levelsOf(0)), false);
  reset();
  document.documentElement.dataset.ready = "yes";
}

start().catch((error) => {
  $("loading").hidden = false;
  $("loading").textContent = `The page cannot be shown: ${error.message}`;
  throw error;
});
