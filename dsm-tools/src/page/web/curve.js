// The curves of pixels: light over depth, exact numbers under the pointer.

const CURVE = { width: 640, height: 360, left: 44, right: 12, bottom: 40 };
/** How lines look, in colour and without: one after the other. */
const DASHES = ["", "8 4", "2 3", "10 3 2 3", "14 5", "5 2 1 2 1 2"];

/** Where depths stand across a drawing: even, or by their logarithms. */
class DepthAxis {
  constructor(near, far, isLog) {
    this.isLog = isLog && near > 0;
    const margin = this.isLog ? 0 : 0.02 * (far - near);
    Object.assign(this, { near: near - margin, far: far + margin });
    if (!(this.far > this.near)) this.far = this.near + Math.max(Math.abs(this.near) * 1e-6, Number.MIN_VALUE);
  }

  place(depth) {
    return this.isLog ? Math.log(depth / this.near) / Math.log(this.far / this.near) : (depth - this.near) / (this.far - this.near);
  }

  depth(place) {
    return this.isLog ? this.near * Math.pow(this.far / this.near, place) : this.near + place * (this.far - this.near);
  }
}

class CurvePlot {
  constructor(parent, readout) {
    this.svg = make("svg", parent, "", { viewBox: `0 0 ${CURVE.width} ${CURVE.height}`, role: "img", tabindex: "0" });
    this.readout = readout;
    this.svg.addEventListener("pointermove", (event) => this.hover(event));
    this.svg.addEventListener("pointerleave", () => this.point(null));
    this.svg.addEventListener("keydown", (event) => this.step(event));
  }

  x(depth) {
    return CURVE.left + Math.min(Math.max(this.axis.place(depth), 0), 1) * (CURVE.width - CURVE.left - CURVE.right);
  }

  y(light) {
    return this.top + (1 - light) * (CURVE.height - this.top - CURVE.bottom);
  }

  /** Draws curves: {name, style, field, pixel, channel}, and where the depth is. */
  draw(curves, axis, depth) {
    // Names stand in rows of three above the drawing.
    Object.assign(this, { curves, axis, top: 10 + 12 * Math.ceil(curves.length / 3) });
    this.svg.replaceChildren();
    make("title", this.svg, `Light that is left over depth, of ${curves.map((curve) => curve.name).join("; ")}`);
    for (let tenth = 0; tenth <= 10; tenth += 2) {
      const y = this.y(tenth / 10);
      make("line", this.svg, "", { class: "grid", x1: CURVE.left, x2: CURVE.width - CURVE.right, y1: y, y2: y });
      make("text", this.svg, (tenth / 10).toFixed(1), { x: CURVE.left - 6, y: y + 4, "text-anchor": "end" });
    }
    for (let tick = 0; tick <= 5; tick++) {
      const place = axis.depth(tick / 5);
      const x = this.x(place);
      make("line", this.svg, "", { class: "grid", x1: x, x2: x, y1: this.top, y2: CURVE.height - CURVE.bottom });
      make("text", this.svg, Number(place.toPrecision(4)), { x, y: CURVE.height - CURVE.bottom + 16, "text-anchor": tick === 5 ? "end" : "middle" });
    }
    make("text", this.svg, axis.isLog ? "depth, logarithmic" : "depth", { x: CURVE.width / 2, y: CURVE.height - 6, "text-anchor": "middle" });
    curves.forEach((curve, index) => {
      const { colour, dash } = curve.style;
      make("path", this.svg, "", { class: "curve", d: this.path(curve), stroke: colour, "stroke-dasharray": dash });
      const x = CURVE.left + 4 + (index % 3) * 200, y = 9 + 12 * Math.floor(index / 3);
      make("path", this.svg, "", { class: "curve", d: `M${x} ${y}h26`, stroke: colour, "stroke-dasharray": dash });
      make("text", this.svg, curve.name.slice(0, 26), { x: x + 31, y: y + 4 });
    });
    this.cursor = make("line", this.svg, "", { class: "cursor", y1: this.top, y2: CURVE.height - CURVE.bottom });
    this.dot = make("circle", this.svg, "", { r: 4, fill: "none", stroke: "currentColor", "stroke-width": 2, visibility: "hidden" });
    this.setDepth(depth);
  }

  setDepth(depth) {
    if (!this.axis) return;
    const x = this.x(depth);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
  }

  path({ field, pixel, channel }) {
    let path = `M${CURVE.left} ${this.y(1)}`;
    let last = [null, 1, 1];
    for (const [depth, before, after] of rowsOfPixel(field, pixel)) {
      if (field.joined === "exponential" && last[0] !== null && before[channel] !== last[2]) {
        for (let part = 1; part < 16; part++) {
          const between = last[0] + (part / 16) * (depth - last[0]);
          path += `L${this.x(between)} ${this.y(field.at(pixel, between, channel))}`;
        }
      }
      const flat = field.joined === "flat" || last[0] === null ? last[2] : before[channel];
      path += `L${this.x(depth)} ${this.y(flat)}L${this.x(depth)} ${this.y(after[channel])}`;
      last = [depth, before[channel], after[channel]];
    }
    return `${path}L${CURVE.width - CURVE.right} ${this.y(last[2])}`;
  }

  /** The row that is nearest to a place in the drawing. */
  hover(event) {
    const box = this.svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * CURVE.width;
    const y = ((event.clientY - box.top) / box.height) * CURVE.height;
    let best = null, least = Infinity;
    this.curves.forEach((curve) => rowsOfPixel(curve.field, curve.pixel).forEach((row, index) => {
      const [depth, before, after] = row;
      const low = this.y(before[curve.channel]), high = this.y(after[curve.channel]);
      const down = y < low ? low - y : y > high ? y - high : 0;
      const apart = Math.hypot(this.x(depth) - x, down);
      if (apart < least) [best, least] = [{ curve, row, index }, apart];
    }));
    this.point(best);
  }

  /** Moves from row to row of the first curve by keys. */
  step(event) {
    const move = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const curve = this.curves?.[0];
    if (!move || !curve) return;
    event.preventDefault();
    const rows = rowsOfPixel(curve.field, curve.pixel);
    if (rows.length === 0) return;
    const index = Math.min(Math.max((this.pointed?.curve === curve ? this.pointed.index : -1) + move, 0), rows.length - 1);
    this.point({ curve, row: rows[index], index });
  }

  point(found) {
    this.pointed = found;
    this.dot.setAttribute("visibility", found ? "visible" : "hidden");
    if (!found) {
      this.readout.textContent = "";
      return;
    }
    const { curve, row: [depth, before, after], index } = found;
    this.dot.setAttribute("cx", this.x(depth));
    this.dot.setAttribute("cy", this.y(after[curve.channel]));
    const light = [before, after].map((values) => shortest(values[curve.channel]));
    this.readout.textContent = `${curve.name}, row ${index + 1}: depth ${shortest(depth)}, before ${light[0]}, at and behind ${light[1]}`;
  }
}
