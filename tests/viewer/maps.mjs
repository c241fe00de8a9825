// Maps of every kind and their pages, made by the program.

import { execFileSync } from "node:child_process";
import { join } from "node:path";

/** Runs the program and answers what it printed. */
export function run(tools, ...words) {
  return execFileSync(tools, words, { encoding: "utf8", maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "pipe"] });
}

/** Maps by name: the arguments of their bake. */
const BAKES = {
  deep: ["builtin:hairball", "--resolution", "96", "--mip"],
  coloured: ["builtin:stained-glass", "--resolution", "64"],
  quantized: ["builtin:fur-plane", "--resolution", "64", "--codec", "quantized", "--tile", "16"],
  mtsm: ["builtin:foliage", "--resolution", "48", "--kind", "mtsm"],
  layers: ["builtin:foliage", "--resolution", "48", "--kind", "layers"],
  fragments: ["builtin:foliage", "--resolution", "48", "--kind", "fragments"],
  media: ["builtin:smoke", "--resolution", "48", "--kind", "fragments"],
  glass: ["builtin:stained-glass", "--resolution", "48", "--kind", "fragments"],
  prefiltered: ["builtin:foliage", "--resolution", "48", "--kind", "prefiltered", "--levels", "mip"],
  attenuation: ["builtin:foliage", "--resolution", "48", "--kind", "attenuation", "--light-samples", "16"],
  views: ["builtin:foliage", "--resolution", "48", "--kind", "views"],
};

/** Makes maps and a page of each: {name, map, page}. */
export function makePages(tools, folder) {
  return Object.entries(BAKES).map(([name, words]) => {
    const [map, page] = [join(folder, `${name}.dsm`), join(folder, `${name}.html`)];
    run(tools, "bake", ...words, "-o", map, "--quiet");
    run(tools, "inspect", map, "--html", page);
    return { name, map, page };
  });
}

/** Two maps that differ, and the page of both. */
export function makePair(tools, folder) {
  const [fine, coarse, page] = ["fine.dsm", "coarse.dsm", "pair.html"].map((name) => join(folder, name));
  for (const [map, tolerance] of [[fine, "0.01"], [coarse, "0.1"]]) {
    run(tools, "bake", "builtin:hairball", "--resolution", "64", "--tolerance", tolerance, "-o", map, "--quiet");
  }
  const difference = JSON.parse(run(tools, "diff", fine, coarse, "--html", page, "--json", "--quiet"));
  return { fine, coarse, page, difference };
}

/** A large map's page, for the time of a step. */
export function makeLarge(tools, folder) {
  const [map, page] = [join(folder, "large.dsm"), join(folder, "large.html")];
  run(tools, "bake", "builtin:hairball", "--resolution", "512", "-o", map, "--quiet");
  run(tools, "inspect", map, "--html", page, "--max-size", "60MB");
  return { map, page };
}
