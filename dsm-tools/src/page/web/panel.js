// A map's picture: one canvas pixel a map pixel, with marks above it.

class Panel {
  /** `choose` is told of pixels that are clicked or moved to. */
  constructor(parent, name, label, choose) {
    this.figure = make("figure", parent);
    this.caption = make("figcaption", this.figure, name);
    this.view = make("div", this.figure, "", { class: "view" });
    this.sheet = make("div", this.view, "", { class: "sheet" });
    this.canvas = make("canvas", this.sheet, "", { tabindex: "0", role: "application", "aria-label": label, "aria-describedby": "help" });
    this.marks = [];
    this.zoom = 1;
    this.canvas.addEventListener("click", (event) => {
      const box = this.canvas.getBoundingClientRect();
      const at = (position, start, length, count) => Math.min(Math.max(Math.floor(((position - start) / length) * count), 0), count - 1);
      choose([at(event.clientX, box.left, box.width, this.canvas.width), at(event.clientY, box.top, box.height, this.canvas.height)]);
    });
  }

  /** Makes the picture this large; what it showed is gone. */
  resize(width, height) {
    if (this.canvas.width === width && this.canvas.height === height && this.image) return;
    Object.assign(this.canvas, { width, height });
    this.context = this.canvas.getContext("2d", { alpha: false, willReadFrequently: true });
    this.image = this.context.createImageData(width, height);
    this.words = new Uint32Array(this.image.data.buffer);
    // A small map is not drawn higher than the window.
    this.sheet.style.maxWidth = this.zoom === 1 ? `calc(70vh * ${width / height})` : "none";
  }

  show() {
    this.context.putImageData(this.image, 0, 0);
  }

  /** Shows a pixel in the middle of this many times as large a picture. */
  enlarge(zoom, [x, y]) {
    this.zoom = zoom;
    this.sheet.style.width = `${100 * zoom}%`;
    this.sheet.style.maxWidth = zoom === 1 ? `calc(70vh * ${this.canvas.width / this.canvas.height})` : "none";
    this.view.scrollTo(((x + 0.5) / this.canvas.width) * this.sheet.clientWidth - this.view.clientWidth / 2,
      ((y + 0.5) / this.canvas.height) * this.sheet.clientHeight - this.view.clientHeight / 2);
  }

  /** Marks pixels: [x, y, label]. */
  mark(pixels) {
    for (const mark of this.marks) mark.remove();
    this.marks = pixels.map(([x, y, label]) => {
      const mark = make("div", this.sheet, "", { class: "mark", "aria-hidden": "true" });
      if (label) make("span", mark, label);
      Object.assign(mark.style, {
        left: `${(100 * (x + 0.5)) / this.canvas.width}%`,
        top: `${(100 * (y + 0.5)) / this.canvas.height}%`,
        width: `${100 / this.canvas.width}%`,
        height: `${100 / this.canvas.height}%`,
      });
      return mark;
    });
  }
}

/** A new element, or one of an SVG, within another. */
function make(name, parent, text = "", attributes = {}) {
  const isDrawing = parent?.namespaceURI === "http://www.w3.org/2000/svg" || name === "svg";
  const element = isDrawing ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== "") element.textContent = text;
  parent?.append(element);
  return element;
}
