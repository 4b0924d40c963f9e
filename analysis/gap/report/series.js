"use strict";
(() => {
  const source = document.getElementById("series-data");
  if (!source) return;
  const root = document.getElementById("series");
  const holder = root.querySelector(".panels");
  const readout = root.querySelector(".readout");
  const all = JSON.parse(source.textContent);
  const HEIGHT = 190, LEFT = 56, RIGHT = 8, TOP = 6, BOTTOM = 34;
  const hidden = new Set();
  let [from, to] = [all.start, all.end];

  const unpack = (series) => {
    const bytes = Uint8Array.from(atob(series.data), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float64Array.from({ length: bytes.length / 2 },
      (_, i) => series.offset + series.scale * view.getInt16(2 * i, true));
  };
  const ticks = (low, high, count) => {
    const raw = (high - low) / count;
    const decade = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * decade).find((s) => s >= raw * 0.999);
    const out = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push(k * step);
    return [out, step];
  };
  const label = (value, step) => {
    if (Math.abs(value) < 1e-9 * step) return "0";
    return value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "−");
  };
  const power = (low, high) => {
    const size = Math.log10(Math.max(Math.abs(low), Math.abs(high)));
    return size < -1.5 || size >= 4.5 ? 3 * Math.floor(size / 3) : 0;
  };
  const raised = (n) => String(n).replaceAll(/./g, (c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);
  const time = (i, n) => all.start + (all.end - all.start) * i / Math.max(n - 1, 1);
  const index = (t, n) => (t - all.start) / Math.max(all.end - all.start, 1e-12) * (n - 1);

  const panels = all.panels.map((panel) => {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    figure.append(caption);
    figure.insertAdjacentHTML("beforeend", `<svg role="img" tabindex="0" viewBox="0 0 480 ${HEIGHT}"></svg>`);
    const svg = figure.querySelector("svg");
    const sizes = panel.series.map((s) => `${s.name} ${s.rms.toPrecision(3)} rms`).join(", ");
    svg.setAttribute("aria-label", `${panel.title} over time in ${panel.unit}: ${sizes}`);
    holder.append(figure);
    return { svg, caption, unit: panel.unit, title: panel.title, drag: null,
      series: panel.series.map((s) => ({ name: s.name, values: unpack(s) })) };
  });

  const element = (svg, name, attributes, text) => {
    const node = document.createElementNS(svg.namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text !== undefined) node.textContent = text;
    svg.append(node);
    return node;
  };

  const path = (values, x, y, width) => {
    const n = values.length;
    const first = Math.max(0, Math.floor(index(from, n)));
    const last = Math.min(n - 1, Math.ceil(index(to, n)));
    const bucket = Math.max(1, Math.floor((last - first) / (2 * width)));
    const points = [];
    for (let i = first; i <= last; i += bucket) {
      let low = i, high = i;
      for (let k = i; k < Math.min(i + bucket, last + 1); k++) {
        if (values[k] < values[low]) low = k;
        if (values[k] > values[high]) high = k;
      }
      for (const k of low === high ? [low] : [Math.min(low, high), Math.max(low, high)]) {
        points.push(`${x(time(k, n)).toFixed(1)} ${y(values[k]).toFixed(1)}`);
      }
    }
    return "M" + points.join("L");
  };

  const extent = (shown) => {
    let low = Infinity, high = -Infinity;
    for (const { values } of shown) {
      const n = values.length;
      const last = Math.min(n - 1, Math.ceil(index(to, n)));
      for (let i = Math.max(0, Math.floor(index(from, n))); i <= last; i++) {
        low = Math.min(low, values[i]);
        high = Math.max(high, values[i]);
      }
    }
    if (!(low <= high)) return [-1, 1];
    const margin = 0.06 * (high - low) || Math.abs(high) || 1;
    return [low - margin, high + margin];
  };

  const draw = (panel) => {
    const { svg } = panel;
    const width = Math.max(240, Math.round(svg.clientWidth || 480));
    svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    svg.replaceChildren();
    const shown = panel.series.filter((s) => !hidden.has(s.name));
    const [low, high] = extent(shown);
    const x = (t) => LEFT + (width - LEFT - RIGHT) * (t - from) / (to - from);
    const y = (v) => TOP + (HEIGHT - TOP - BOTTOM) * (high - v) / (high - low);
    panel.geometry = { width, x, invert: (px) => from + (to - from) * (px - LEFT) / (width - LEFT - RIGHT) };
    const [rows, rowStep] = ticks(low, high, 6);
    const exponent = power(low, high);
    for (const v of rows) {
      element(svg, "path", { class: "grid", d: `M${LEFT} ${y(v)}H${width - RIGHT}` });
      element(svg, "text", { x: LEFT - 6, y: y(v) + 4, "text-anchor": "end" },
        label(v / 10 ** exponent, rowStep / 10 ** exponent));
    }
    panel.caption.textContent = exponent ? `${panel.title} [10${raised(exponent)} ${panel.unit}]` : `${panel.title} [${panel.unit}]`;
    const [columns, columnStep] = ticks(from, to, Math.max(2, Math.floor(width / 90)));
    for (const t of columns) {
      element(svg, "path", { class: "grid", d: `M${x(t)} ${TOP}V${HEIGHT - BOTTOM}` });
      element(svg, "text", { x: x(t), y: HEIGHT - BOTTOM + 14, "text-anchor": "middle" }, label(t, columnStep));
    }
    element(svg, "text", { x: (LEFT + width - RIGHT) / 2, y: HEIGHT - 4, "text-anchor": "middle" }, "time [s]");
    for (const s of shown) {
      element(svg, "path", { class: `curve ${s.name}`, d: path(s.values, x, y, width - LEFT - RIGHT) });
    }
    panel.cursor = element(svg, "path", { class: "cursor", d: "" });
    panel.box = element(svg, "rect", { class: "drag", y: TOP, height: HEIGHT - TOP - BOTTOM, x: 0, width: 0 });
  };
  const drawAll = () => panels.forEach(draw);

  const view = (a, b) => {
    const least = 20 * (all.end - all.start) / 12000;
    const span = Math.min(Math.max(b - a, least), all.end - all.start);
    from = Math.min(Math.max(a, all.start), all.end - span);
    to = from + span;
    drawAll();
  };
  const act = {
    in: () => view(from + 0.25 * (to - from), to - 0.25 * (to - from)),
    out: () => view(from - 0.5 * (to - from), to + 0.5 * (to - from)),
    left: () => view(from - 0.25 * (to - from), to - 0.25 * (to - from)),
    right: () => view(from + 0.25 * (to - from), to + 0.25 * (to - from)),
    all: () => view(all.start, all.end),
  };
  const keys = { "+": "in", "=": "in", "-": "out", ArrowLeft: "left", ArrowRight: "right", 0: "all" };
  root.querySelectorAll("button[data-do]").forEach((b) => b.addEventListener("click", act[b.dataset.do]));

  const read = (panel, t) => {
    const parts = panel.series.filter((s) => !hidden.has(s.name)).map((s) => {
      const i = Math.round(index(t, s.values.length));
      return `${s.name} ${s.values[Math.min(Math.max(i, 0), s.values.length - 1)].toPrecision(3)}`;
    });
    readout.textContent = `${panel.title}, t = ${t.toFixed(3)} s: ${parts.join(", ")} ${panel.unit}`.replaceAll("-", "−");
  };
  for (const panel of panels) {
    const { svg } = panel;
    const at = (event) => {
      const box = svg.getBoundingClientRect();
      const px = (event.clientX - box.left) * panel.geometry.width / box.width;
      return Math.min(Math.max(panel.geometry.invert(px), from), to);
    };
    svg.addEventListener("pointerdown", (event) => {
      panel.drag = at(event);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      const t = at(event);
      const { x } = panel.geometry;
      panel.cursor.setAttribute("d", `M${x(t)} ${TOP}V${HEIGHT - BOTTOM}`);
      read(panel, t);
      if (panel.drag === null) return;
      panel.box.setAttribute("x", Math.min(x(t), x(panel.drag)));
      panel.box.setAttribute("width", Math.abs(x(t) - x(panel.drag)));
    });
    svg.addEventListener("pointerup", (event) => {
      const [start, end] = [panel.drag, at(event)];
      panel.drag = null;
      if (start !== null && Math.abs(end - start) > 0.01 * (to - from)) view(Math.min(start, end), Math.max(start, end));
      else panel.box.setAttribute("width", 0);
    });
    svg.addEventListener("pointercancel", () => { panel.drag = null; panel.box.setAttribute("width", 0); });
    svg.addEventListener("pointerleave", () => panel.cursor.setAttribute("d", ""));
    svg.addEventListener("dblclick", act.all);
    svg.addEventListener("keydown", (event) => {
      const name = keys[event.key];
      if (!name || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act[name]();
    });
  }

  const legend = root.querySelector(".legend");
  const names = new Set(["measured", ...panels.flatMap((p) => p.series.map((s) => s.name))]);
  for (const name of names) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = name;
    button.textContent = name;
    button.setAttribute("aria-pressed", "true");
    button.addEventListener("click", () => {
      if (!hidden.delete(name)) hidden.add(name);
      button.setAttribute("aria-pressed", String(!hidden.has(name)));
      drawAll();
    });
    legend.append(button);
  }
  new ResizeObserver(drawAll).observe(holder);
  drawAll();
})();
