"use strict";
(async () => {
  const root = document.documentElement;
  // what is linked, or printed, is not folded
  const unfold = () => document.getElementById(decodeURIComponent(location.hash.slice(1)))?.querySelector("details")?.setAttribute("open", "");
  addEventListener("hashchange", unfold);
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((one) => (one.open = true)));
  unfold();
  if (!root.classList.contains("live")) return; // the still pictures stand

  const unpack = async (id) => {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  };
  let pictures;
  try {
    const script = document.createElement("script");
    script.textContent = await unpack("packed-plotly");
    document.head.append(script);
    pictures = JSON.parse(await unpack("packed-pictures"));
  } catch {
    root.classList.remove("live");
    return;
  }

  const boxes = [...document.querySelectorAll(".runs input")];
  const isShown = (run) => run === undefined || boxes[run].checked;
  const drawn = new Set();

  // colors are named in the pictures and defined in the style sheet, light and dark
  const tinted = (value, style) => {
    if (typeof value === "string")
      return value.startsWith("var(") ? style.getPropertyValue(value.slice(4, -1)).trim() : value;
    if (Array.isArray(value)) return typeof value[0] === "number" ? value : value.map((v) => tinted(v, style));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, v]) => [key, tinted(v, style)]));
  };

  const draw = (plot) => {
    const figure = tinted(pictures[plot.dataset.picture], getComputedStyle(root));
    for (const trace of figure.data) trace.visible = isShown(trace.meta?.run);
    // a finger scrolls the page, a mouse zooms
    figure.layout.dragmode = matchMedia("(pointer: coarse)").matches ? false : "zoom";
    if (plot.clientWidth < 420) {
      figure.layout.font.size = 11;
      figure.layout.margin.l = Math.min(figure.layout.margin.l, 52);
    }
    const place = plot.querySelector(".drawn");
    Plotly.react(place, figure.data, figure.layout, { displayModeBar: false, responsive: true });
    if (!drawn.has(plot)) {
      drawn.add(plot);
      place.on("plotly_hover", (event) => say(plot, event.points));
      place.on("plotly_unhover", () => say(plot, []));
    }
    plot.dataset.ready = "true";
  };

  const say = (plot, points) => {
    const number = (v) => (typeof v === "number" ? String(Number(v.toPrecision(4))) : v);
    const values = points.map(({ x, y, data }) => {
      const [at, value] = data.orientation === "h" ? [y, x] : [x, y];
      return `${data.name ? data.name + ": " : ""}${number(at)}${data.meta.at} → ${number(value)} ${data.meta.unit}`;
    });
    plot.querySelector(".reading").textContent = values.join("; ");
  };

  // without a mouse: left and right step along a curve, up and down from curve to curve
  const at = new WeakMap();
  const step = (plot, key) => {
    const place = plot.querySelector(".drawn");
    const unified = place.layout.hovermode === "x unified";
    const curves = place.data.map((trace, i) => i).filter((i) => place.data[i].visible !== false);
    if (!curves.length) return;
    const now = at.get(plot) ?? { curve: 0, point: -1 };
    if (key === "ArrowUp" || key === "ArrowDown") now.curve += key === "ArrowDown" ? 1 : -1;
    now.curve = (now.curve + curves.length) % curves.length;
    const last = place.data[curves[now.curve]].x.length - 1;
    const goal = { ArrowRight: now.point + 1, ArrowLeft: now.point - 1, Home: 0, End: last }[key] ?? now.point;
    now.point = Math.max(0, Math.min(last, goal));
    at.set(plot, now);
    const read = unified ? curves : [curves[now.curve]];
    Plotly.Fx.hover(place, read.map((curveNumber) => ({ curveNumber, pointNumber: now.point })));
    say(plot, read.map((i) => ({ data: place.data[i], x: place.data[i].x[now.point], y: place.data[i].y[now.point] })));
  };
  document.addEventListener("keydown", (event) => {
    const plot = event.target.closest?.(".plot");
    if (!plot || !/^(Arrow(Left|Right|Up|Down)|Home|End)$/.test(event.key)) return;
    event.preventDefault();
    step(plot, event.key);
  });

  const showRuns = () => {
    for (const figure of document.querySelectorAll(".facets > figure")) {
      const back = figure.hidden && isShown(+figure.dataset.run);
      figure.hidden = !isShown(+figure.dataset.run);
      const place = figure.querySelector(".drawn");
      if (back && place.data) Plotly.Plots.resize(place); // the window may have changed meanwhile
    }
    for (const plot of drawn) {
      const place = plot.querySelector(".drawn");
      const runs = place.data.map((trace) => trace.meta?.run);
      if (runs.some((run) => run !== undefined)) Plotly.restyle(place, { visible: runs.map(isShown) });
    }
  };
  for (const box of boxes) box.addEventListener("change", showRuns);
  for (const button of document.querySelectorAll("[data-every]"))
    button.addEventListener("click", () => {
      for (const box of boxes) box.checked = Boolean(button.dataset.every);
      showRuns();
    });

  for (const plot of document.querySelectorAll(".plot"))
    plot.querySelector(".drawn").style.height = `${pictures[plot.dataset.picture].layout.height}px`;

  // what is near the window is drawn first, the rest when there is nothing else to do
  const near = new IntersectionObserver(
    (seen) => {
      for (const { isIntersecting, target } of seen)
        if (isIntersecting) {
          near.unobserve(target);
          draw(target);
        }
    },
    { rootMargin: "600px" },
  );
  for (const plot of document.querySelectorAll(".plot")) near.observe(plot);
  const whenIdle = window.requestIdleCallback ?? ((work) => setTimeout(work, 100));
  const drawRest = () => {
    const plot = [...document.querySelectorAll(".plot")].find((one) => !drawn.has(one) && one.clientWidth > 0);
    if (!plot) return;
    near.unobserve(plot);
    draw(plot);
    whenIdle(drawRest);
  };
  whenIdle(drawRest);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(draw));
  root.dataset.ready = "true";
})();
