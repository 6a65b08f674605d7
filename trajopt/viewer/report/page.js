"use strict";
// One moment for the whole page: the motion in 3-D, a line in each plot, the values in the legends.
(() => {
  const frame = document.querySelector("iframe");
  const space = document.querySelector(".space");
  const plots = [...document.querySelectorAll("svg.plot")];
  const number = (plot, name) => Number(plot.dataset[name]);

  const across = (plot, time) =>
    number(plot, "left") + (number(plot, "right") - number(plot, "left")) * (time / number(plot, "end"));

  // The height of a curve at a place: between the two points of it that are beside, where nothing is left out.
  const height = (points, x) => {
    for (let k = 1; k < points.length; k++) {
      const [before, after] = [points[k - 1], points[k]];
      if (!after[2] && before[0] <= x && x <= after[0] + 0.05) {
        const width = after[0] - before[0];
        return before[1] + (width > 0 ? (x - before[0]) / width : 0) * (after[1] - before[1]);
      }
    }
    return null;
  };
  const curves = new Map(plots.map((plot) => [
    plot,
    [...plot.querySelectorAll("path.curve")].map((path) =>
      [...path.getAttribute("d").matchAll(/([ML])([\d.-]+) ([\d.-]+)/g)].map(([, pen, x, y]) =>
        [Number(x), Number(y), pen === "M"])),
  ]));

  const mark = (time) => {
    for (const plot of plots) {
      const x = Math.min(Math.max(across(plot, time), number(plot, "left")), number(plot, "right"));
      const cursor = plot.querySelector(".cursor");
      cursor.setAttribute("transform", `translate(${x} 0)`);
      cursor.setAttribute("visibility", "visible");
      const values = plot.parentElement.querySelectorAll(".legend b");
      const [top, bottom, upper, lower] = ["top", "bottom", "upper", "lower"].map((name) => number(plot, name));
      curves.get(plot).forEach((points, line) => {
        const y = height(points, x);
        const value = y === null ? null : lower + ((bottom - y) / (bottom - top)) * (upper - lower);
        if (values[line]) values[line].textContent = value === null ? "–" : value.toPrecision(3);
      });
    }
  };
  const show = (time) => {
    mark(time);
    if (frame) frame.contentWindow.postMessage({ show: time }, "*");
  };

  addEventListener("message", (event) => {
    if (!frame || event.source !== frame.contentWindow) return;
    if (Number.isFinite(event.data.time)) mark(event.data.time);
    if (event.data.drawn) space.classList.remove("waiting");
  });
  if (space && !document.createElement("canvas").getContext("webgl2")) space.classList.add("impossible");
  for (const button of document.querySelectorAll("button.at")) {
    button.addEventListener("click", () => {
      show(Number(button.dataset.at));
      if (space) space.scrollIntoView({ block: "nearest" });
    });
  }
  for (const plot of plots) {
    const pick = (event) => {
      const box = plot.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * plot.viewBox.baseVal.width;
      const share = (x - number(plot, "left")) / (number(plot, "right") - number(plot, "left"));
      show(Math.min(Math.max(share, 0), 1) * number(plot, "end"));
    };
    plot.addEventListener("pointerdown", (event) => { plot.setPointerCapture(event.pointerId); pick(event); });
    plot.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });
  }
})();
