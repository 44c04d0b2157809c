// Draws every figure of the page, in the page's colours; chips switch methods on and off.
(() => {
  "use strict";
  const { items, motions } = spincheck;
  const plots = [...document.querySelectorAll(".plot")].map((div) => ({
    div,
    scope: scopeOf(div),
    spec: items[div.dataset.packed],
  }));
  // Methods that are switched off, by the part of the page that their chips are for.
  const hidden = new Map();
  // Which of a method's stock timesteps is drawn: its engine's own, or the one of all engines.
  let common = false;
  // A copy of the page's switches of methods for each of its parts.
  const switches = document.getElementById("switches");
  for (const place of document.querySelectorAll("[data-shown]")) {
    place.prepend(switches.content.cloneNode(true));
    const shown = JSON.parse(place.dataset.shown);
    for (const chip of place.querySelectorAll("[data-method]"))
      chip.setAttribute("aria-pressed", String("every" in place.dataset || shown.includes(chip.dataset.method)));
  }
  const config = {
    responsive: true,
    displaylogo: false,
    // Nothing leaves this page.
    showSendToCloud: false,
    plotlyServerURL: "",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    toImageButtonOptions: { format: "svg" },
  };

  // A figure is drawn when the reader comes near it, px, the others once the page is idle, ms: to
  // read Plotly takes a second, in which a page does not answer.
  const NEAR = 400, IDLE = 3000;

  // Plotly's source is run from memory.
  function loadPlotly() {
    if (typeof Plotly !== "undefined") return;
    const script = document.createElement("script");
    script.textContent = spincheck.source(packedPlotly);
    document.head.append(script);
  }

  function scopeOf(element) {
    return element.closest("[data-scope]")?.dataset.scope ?? "";
  }

  function hiddenIn(scope) {
    if (!hidden.has(scope)) hidden.set(scope, new Set());
    return hidden.get(scope);
  }

  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // A figure with the page's colours in place of their names.
  function inked(value, colours) {
    if (typeof value === "string") return colours[value] ?? value;
    if (Array.isArray(value)) return value.map((item) => inked(item, colours));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, inked(v, colours)]));
  }

  function theme() {
    const axis = {
      gridcolor: colour("--grid"),
      linecolor: colour("--muted"),
      showline: true,
      ticks: "outside",
      tickcolor: colour("--muted"),
      ticklen: 4,
      automargin: true,
      title: { standoff: 8, font: { size: 13 } },
    };
    return {
      layout: {
        font: { family: "system-ui, sans-serif", size: 13, color: colour("--ink") },
        paper_bgcolor: "rgba(0,0,0,0)",
        plot_bgcolor: "rgba(0,0,0,0)",
        margin: { l: 64, r: 14, t: 34, b: 46 },
        hoverlabel: { align: "left" },
        modebar: {
          bgcolor: "rgba(0,0,0,0)",
          color: colour("--muted"),
          activecolor: colour("--link"),
        },
        xaxis: axis,
        yaxis: axis,
      },
    };
  }

  // Of each method the run at the timestep that is chosen.
  function runsDrawn() {
    const chosen = new Map();
    for (const run of motions.runs)
      if (!chosen.has(run.label) || common) chosen.set(run.label, run);
    return [...chosen.values()];
  }

  // The lines that a figure leaves to the motions of the page.
  function overlaid({ overlays = [] }) {
    return overlays.flatMap((overlay) => {
      const made = spincheck.lines[overlay.kind];
      const panel = overlay.panel > 1 ? overlay.panel : "";
      const axes = overlay.panel ? { xaxis: `x${panel}`, yaxis: `y${panel}` } : {};
      const common = { mode: "lines", showlegend: false, type: overlay.panel ? "scatter" : "scatter3d", ...axes };
      const lines = runsDrawn().flatMap((run) => {
        const [ink, dash] = run.look;
        const at = made(run.motion, run, overlay, motions.body);
        const line = {
          ...common, ...at, name: run.name, legendgroup: run.label,
          line: { color: ink, dash, width: overlay.panel ? 1.6 : 3 },
          hovertemplate: overlay.panel ? `${run.hover}<br>%{x:.4g}, %{y:.4g}<extra></extra>` : undefined,
          hoverinfo: "name",
        };
        if (!overlay.noticed || run.noticed === null) return [line];
        const x = run.noticed;
        const dot = {
          ...common, mode: "markers", x: [x], y: [motions.noticeable], legendgroup: run.label,
          marker: { color: ink, size: 10, line: { color: "ink", width: 1.5 } },
          hovertemplate: `${run.hover}<br>off by more than 1° from ${x.toPrecision(3)} s on<extra></extra>`,
        };
        return [line, dot];
      });
      if (!overlay.exact) return lines;
      const at = made(motions[overlay.exact], null, overlay, motions.body);
      const exact = { ...common, ...at, name: "exact", hoverinfo: "skip", line: { color: "ink", width: 5 } };
      return [exact, ...lines];
    });
  }

  const shownIn = (scope) => (trace) => !hiddenIn(scope).has(trace.legendgroup);

  function drawOne({ div, scope, spec }) {
    const colours = { ink: colour("--ink"), wire: colour("--wire"), ground: colour("--paper") };
    const { data, layout } = spec;
    const lines = motions ? overlaid(spec) : [];
    const figure = inked({ data: [...data, ...lines], layout }, colours);
    for (const trace of figure.data) trace.visible = shownIn(scope)(trace);
    Plotly.react(div, figure.data, { ...figure.layout, template: theme() }, config);
  }

  // One at a time, so that the page answers in between.
  async function draw(chosen) {
    loadPlotly();
    for (const plot of chosen) {
      drawOne(plot);
      await new Promise((resolve) => setTimeout(resolve));
    }
  }
  const drawn = () => plots.filter(({ div }) => div.data);

  const coming = new IntersectionObserver((seen) => {
    const near = new Set(seen.filter((one) => one.isIntersecting).map((one) => one.target));
    for (const div of near) coming.unobserve(div);
    if (near.size) draw(plots.filter(({ div }) => near.has(div)));
  }, { rootMargin: `${NEAR}px` });

  function toggled(scope) {
    for (const plot of plots)
      if (plot.scope === scope && plot.div.data)
        Plotly.restyle(plot.div, { visible: plot.div.data.map(shownIn(scope)) });
    for (const chip of document.querySelectorAll("[data-method]"))
      if (scopeOf(chip) === scope)
        chip.setAttribute("aria-pressed", String(!hiddenIn(scope).has(chip.dataset.method)));
  }

  for (const chip of document.querySelectorAll("[data-method]")) {
    const set = hiddenIn(scopeOf(chip));
    if (chip.getAttribute("aria-pressed") === "false") set.add(chip.dataset.method);
    chip.addEventListener("click", () => {
      const method = chip.dataset.method;
      if (!set.delete(method)) set.add(method);
      toggled(scopeOf(chip));
    });
  }
  for (const button of document.querySelectorAll("[data-all]"))
    button.addEventListener("click", () => {
      const scope = scopeOf(button), set = hiddenIn(scope);
      set.clear();
      if (button.dataset.all === "false")
        for (const chip of document.querySelectorAll("[data-method]"))
          if (scopeOf(chip) === scope) set.add(chip.dataset.method);
      toggled(scope);
    });
  for (const select of document.querySelectorAll("[data-timestep]"))
    select.addEventListener("change", () => {
      common = select.value === "common";
      for (const other of document.querySelectorAll("[data-timestep]")) other.value = select.value;
      draw(drawn().filter(({ spec }) => spec.overlays));
    });

  // Folded tables are made when they are asked for.
  function filled(place) {
    const { headings, rows } = items[place.dataset.table];
    const made = (tag, text = "", parent = null, kind = "") => {
      const element = document.createElement(tag);
      element.textContent = text;
      if (kind) element.className = kind;
      parent?.append(element);
      return element;
    };
    const table = made("table", "", null, place.dataset.classes);
    const head = made("tr", "", made("thead", "", table));
    for (const heading of headings) made("th", heading, head).scope = "col";
    const body = made("tbody", "", table);
    for (const row of rows) {
      const line = made("tr", "", body);
      for (const [text, kind, detail, link, note] of row) {
        const cell = made("td", link ? "" : text, line, kind);
        if (link) made("a", text, cell).href = link;
        if (detail) made("span", detail, cell, "detail");
        if (!note) continue;
        const why = made("details", "", cell, "note");
        made("summary", kind ? "why" : "more", why);
        why.append(note);
      }
    }
    place.replaceChildren(table);
  }
  for (const details of document.querySelectorAll("details"))
    details.addEventListener("toggle", () => {
      for (const place of details.querySelectorAll("[data-table]:empty")) filled(place);
    });

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw(drawn()));
  // Paper is white whatever the screen is.
  addEventListener("beforeprint", () => {
    document.documentElement.dataset.paper = "";
    loadPlotly();
    for (const plot of plots) {
      if (plot.div.data) Plotly.Plots.resize(plot.div);
      drawOne(plot);
    }
  });
  addEventListener("afterprint", () => {
    delete document.documentElement.dataset.paper;
    for (const { div } of drawn()) Plotly.Plots.resize(div);
    draw(drawn());
  });
  for (const { div } of plots) coming.observe(div);
  if (plots.length)
    setTimeout(() => requestIdleCallback(() => draw(plots.filter(({ div }) => !div.data))), IDLE);
})();
