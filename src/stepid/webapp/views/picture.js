// A picture by plotly: colors are named, the style sheet has them, light and dark; arrow keys read the values.
export function render({ model, el }) {
  const plot = document.createElement("div");
  plot.className = "plot";
  plot.tabIndex = 0;
  plot.setAttribute("role", "group");
  plot.setAttribute("aria-label", `${model.label} Arrow keys read the values.`);
  const place = document.createElement("div");
  place.className = "drawn";
  const reading = document.createElement("p");
  reading.className = "unseen reading";
  reading.setAttribute("aria-live", "polite");
  plot.append(place, reading);
  const dark = matchMedia("(prefers-color-scheme: dark)");

  const tinted = (value, style) => {
    if (typeof value === "string")
      return value.startsWith("var(") ? style.getPropertyValue(value.slice(4, -1)).trim() : value;
    if (Array.isArray(value)) return typeof value[0] === "number" ? value : value.map((v) => tinted(v, style));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, v]) => [key, tinted(v, style)]));
  };
  const draw = () => {
    if (!place.isConnected || !model.figure.layout) return;
    const figure = tinted(model.figure, getComputedStyle(plot));
    figure.layout.dragmode = matchMedia("(pointer: coarse)").matches ? false : "zoom";
    if (plot.clientWidth < 420) {
      figure.layout.font.size = 11;
      figure.layout.margin.l = Math.min(figure.layout.margin.l, 52);
    }
    place.style.height = `${figure.layout.height}px`;
    window.Plotly.react(place, figure.data, figure.layout, { displayModeBar: false, responsive: false });
    plot.dataset.drawn = String(Number(plot.dataset.drawn ?? 0) + 1);
  };

  let at = { curve: 0, point: -1 };
  const step = (key) => {
    const curves = place.data?.map((trace, i) => i).filter((i) => place.data[i].x?.length) ?? [];
    if (!curves.length) return;
    if (key === "ArrowUp" || key === "ArrowDown") at.curve += key === "ArrowDown" ? 1 : -1;
    at.curve = (at.curve + curves.length) % curves.length;
    const trace = place.data[curves[at.curve]];
    const last = trace.x.length - 1;
    const goal = { ArrowRight: at.point + 1, ArrowLeft: at.point - 1, Home: 0, End: last }[key] ?? at.point;
    at.point = Math.max(0, Math.min(last, goal));
    window.Plotly.Fx.hover(place, [{ curveNumber: curves[at.curve], pointNumber: at.point }]);
    const number = (v) => (typeof v === "number" ? String(Number(v.toPrecision(4))) : v);
    const [x, y] = trace.orientation === "h" ? [trace.y, trace.x] : [trace.x, trace.y];
    const meta = trace.meta ?? { at: "", unit: "" };
    reading.textContent =
      `${trace.name ? trace.name + ": " : ""}${number(x[at.point])}${meta.at} → ${number(y[at.point])} ${meta.unit}`;
  };
  plot.addEventListener("keydown", (event) => {
    if (!/^(Arrow(Left|Right|Up|Down)|Home|End)$/.test(event.key)) return;
    event.preventDefault();
    step(event.key);
  });

  // drawn when it comes near the window, else when there is nothing to do: a page of many runs is there at once
  let near = false;
  const first = () => {
    if (near) return;
    near = true;
    draw();
  };
  const seen = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && first(), {
    rootMargin: "600px",
  });
  const whenIdle = window.requestIdleCallback ?? ((work) => setTimeout(work, 500));
  whenIdle(() => plot.clientWidth > 0 && first());
  const widened = new ResizeObserver(() => near && place.data && window.Plotly.Plots.resize(place));
  plot.style.minHeight = `${model.figure.layout?.height ?? 0}px`;
  seen.observe(plot);
  widened.observe(plot);
  const redraw = () => near && draw();
  dark.addEventListener("change", redraw);
  model.on("figure", redraw);
  model.on("remove", () => {
    dark.removeEventListener("change", redraw);
    seen.disconnect();
    widened.disconnect();
    if (place.data) window.Plotly.purge(place);
  });
  return plot;
}
