// The light's camera in space, with the frustum in which receivers are shaded.

/** A matrix of 16 numbers, column after column, times a point. */
function transform(matrix, [x, y, z], w = 1) {
  return [0, 1, 2, 3].map((row) => matrix[row] * x + matrix[4 + row] * y + matrix[8 + row] * z + matrix[12 + row] * w);
}

/** The inverse of a matrix that keeps parallels parallel. */
function affineInverse(m) {
  const [a, b, c, d, e, f, g, h, i] = [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]];
  const determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
  const rows = [[e * i - f * h, c * h - b * i, b * f - c * e], [f * g - d * i, a * i - c * g, c * d - a * f], [d * h - e * g, b * g - a * h, a * e - b * d]]
    .map((row) => row.map((value) => value / determinant));
  const move = rows.map((row) => -(row[0] * m[12] + row[1] * m[13] + row[2] * m[14]));
  return [rows[0][0], rows[1][0], rows[2][0], 0, rows[0][1], rows[1][1], rows[2][1], 0, rows[0][2], rows[1][2], rows[2][2], 0, ...move, 1];
}

/** The places of a map's pixels in the world. */
class MapCamera {
  constructor(summary) {
    const { world_to_camera: toCamera, world_to_ndc: toNdc } = summary.camera;
    this.toWorld = affineInverse(toCamera);
    const columns = [0, 1, 2, 3].map((column) => transform(toNdc, this.toWorld.slice(4 * column, 4 * column + 3), this.toWorld[4 * column + 3]));
    this.projection = columns.flat();
    const { data_window: data, display_window: display, width, height } = summary;
    const window = display ?? data;
    this.corner = data && window ? [data.min[0] - window.min[0], data.min[1] - window.min[1]] : [0, 0];
    this.size = window ? [window.max[0] - window.min[0] + 1, window.max[1] - window.min[1] + 1] : [width, height];
  }

  world(point) {
    return transform(this.toWorld, point).slice(0, 3);
  }

  /** The place at a depth in the raster of level 0. */
  at([column, row], depth) {
    const [u, v] = [(column + this.corner[0]) / this.size[0], (row + this.corner[1]) / this.size[1]];
    const p = this.projection, z = -depth;
    const w = p[11] * z + p[15];
    const [a, b, e] = [p[0] - u * p[3], p[4] - u * p[7], u * w - (p[8] * z + p[12])];
    const [c, d, f] = [p[1] - v * p[3], p[5] - v * p[7], v * w - (p[9] * z + p[13])];
    const determinant = a * d - b * c;
    return this.world([(e * d - b * f) / determinant, (a * f - e * c) / determinant, z]);
  }
}

class CameraView {
  constructor(parent, text, summary, range) {
    this.svg = make("svg", parent, "", { viewBox: "0 0 480 320", role: "application", tabindex: "0", "aria-label": "The light's camera in space; arrow keys turn it" });
    Object.assign(this, { summary, range, camera: new MapCamera(summary), turn: [0.7, 0.45] });
    this.lightDepth = summary.layering?.light_depth ?? 0;
    const eye = this.camera.world([0, 0, -this.lightDepth]);
    const ahead = this.camera.world([0, 0, -this.lightDepth - 1]).map((value, axis) => value - eye[axis]);
    text.textContent = `Light at (${eye.map(short).join(", ")}), looking along (${ahead.map(short).join(", ")}). Solid: the frustum in which receivers are shaded, between depths ${short(range[0])} and ${short(range[1])}; dashed: the light and its depth.`;
    let from = null;
    this.svg.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; this.svg.setPointerCapture(event.pointerId); });
    this.svg.addEventListener("pointermove", (event) => {
      if (!from) return;
      this.rotate((event.clientX - from[0]) * 0.01, (event.clientY - from[1]) * 0.01);
      from = [event.clientX, event.clientY];
    });
    this.svg.addEventListener("pointerup", () => { from = null; });
    this.svg.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (by) { event.preventDefault(); this.rotate(...by); }
    });
    this.svg.style.touchAction = "pan-y";
  }

  rotate(across, down) {
    this.turn = [this.turn[0] + across, Math.min(Math.max(this.turn[1] + down, -1.5), 1.5)];
    this.draw(this.depth, this.pixel);
  }

  /** The outline of the light in its plane. */
  outline() {
    const light = this.summary.light;
    const [width, height] = light?.size ?? [0, 0];
    const steps = !light || light.shape === "point" ? 0 : light.shape === "rectangle" ? 4 : 32;
    return Array.from({ length: steps }, (_, step) => {
      const angle = ((step + (steps === 4 ? 0.5 : 0)) / steps) * 2 * Math.PI;
      const reach = steps === 4 ? Math.SQRT1_2 : 0.5;
      return this.camera.world([width * reach * Math.cos(angle), height * reach * Math.sin(angle), -this.lightDepth]);
    });
  }

  /** Draws the frustum, the depth and the ray of a pixel of level 0 (or null). */
  draw(depth, pixel) {
    Object.assign(this, { depth, pixel });
    const { width, height, eyes } = this.summary;
    const corners = [[0, 0], [width, 0], [width, height], [0, height]];
    const plane = (at) => corners.map((corner) => this.camera.at(corner, at));
    const [near, far] = this.range;
    const eye = this.camera.world([0, 0, 0]);
    const quads = { near: plane(near), far: plane(far), now: plane(Math.min(Math.max(depth, near), far)) };
    const outline = this.outline();
    const all = [eye, ...quads.near, ...quads.far, ...outline].filter((point) => point.every(Number.isFinite));
    const middle = [0, 1, 2].map((axis) => all.reduce((sum, point) => sum + point[axis], 0) / all.length);
    const reach = Math.max(...all.map((point) => Math.hypot(...point.map((value, axis) => value - middle[axis])))) || 1;
    const [cosA, sinA, cosB, sinB] = [Math.cos(this.turn[0]), Math.sin(this.turn[0]), Math.cos(this.turn[1]), Math.sin(this.turn[1])];
    const place = (point) => {
      const [x, y, z] = point.map((value, axis) => (value - middle[axis]) / reach);
      const ahead = -sinA * x + cosA * z;
      return [240 + 150 * (cosA * x + sinA * z), 160 - 150 * (cosB * y - sinB * ahead)].map((value) => Number(value.toFixed(2)));
    };
    const line = (points, colour, more = {}) => make("polyline", this.svg, "", { points: points.map((point) => place(point).join(",")).join(" "), fill: "none", stroke: colour, "stroke-width": 1.5, ...more });
    const closed = (points) => [...points, points[0]];
    this.svg.replaceChildren();
    make("title", this.svg, "Camera");
    // The world's axes, from the middle of what is drawn.
    ["x", "y", "z"].forEach((name, axis) => {
      const end = middle.map((value, index) => value + (index === axis ? 0.3 * reach : 0));
      line([middle, end], "var(--soft)");
      const [x, y] = place(end);
      make("text", this.svg, name, { x: x + 3, y });
    });
    line(closed(quads.near), "var(--c0)");
    line(closed(quads.far), "var(--c0)");
    quads.near.forEach((corner, index) => {
      line([corner, quads.far[index]], "var(--c0)");
      line([eye, corner], "var(--c0)", { "stroke-dasharray": "2 3" });
    });
    line(closed(quads.now), "var(--c1)", { fill: "var(--c1)", "fill-opacity": 0.15, "stroke-dasharray": "6 3" });
    if (outline.length > 0) line(closed(outline), "var(--c1)", { "stroke-dasharray": "4 2", "stroke-width": 2.5 });
    for (const point of eyes ? eyes.map((at) => this.camera.world(at)) : [this.camera.world([0, 0, -this.lightDepth])]) {
      const [cx, cy] = place(point);
      make("circle", this.svg, "", { cx, cy, r: 4, fill: "var(--c1)" });
    }
    if (pixel) {
      const at = pixel.map((value) => value + 0.5);
      line([this.camera.at(at, near), this.camera.at(at, far)], "var(--c2)", { "stroke-width": 2.5 });
    }
  }
}
