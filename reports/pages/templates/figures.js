// Draws every figure of the page, in the page's colours, and lets the chips switch methods off.
(() => {
  "use strict";
  const hidden = new Set();
  const plots = [...document.querySelectorAll(".plot")].map((div) => ({
    div,
    spec: JSON.parse(div.nextElementSibling.textContent),
  }));
  const config = {
    responsive: true,
    displaylogo: false,
    // Nothing leaves this page.
    showSendToCloud: false,
    plotlyServerURL: "",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    toImageButtonOptions: { format: "svg" },
  };

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
        margin: { l: 70, r: 16, t: 40, b: 52 },
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

  function shown(trace) {
    return !hidden.has(trace.legendgroup);
  }

  function draw() {
    const template = theme();
    const colours = {
      ink: colour("--ink"),
      wire: colour("--wire"),
      ground: colour("--paper"),
    };
    for (const { div, spec } of plots) {
      const figure = inked(spec, colours);
      for (const trace of figure.data) trace.visible = shown(trace);
      Plotly.react(div, figure.data, { ...figure.layout, template }, config);
    }
  }

  function toggled() {
    for (const { div } of plots) Plotly.restyle(div, { visible: div.data.map(shown) });
    for (const chip of document.querySelectorAll("[data-method]"))
      chip.setAttribute("aria-pressed", String(!hidden.has(chip.dataset.method)));
  }

  for (const chip of document.querySelectorAll("[data-method]"))
    chip.addEventListener("click", () => {
      const method = chip.dataset.method;
      if (!hidden.delete(method)) hidden.add(method);
      toggled();
    });
  for (const button of document.querySelectorAll("[data-all]"))
    button.addEventListener("click", () => {
      hidden.clear();
      if (button.dataset.all === "false")
        for (const chip of document.querySelectorAll("[data-method]"))
          hidden.add(chip.dataset.method);
      toggled();
    });

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  // Paper is white whatever the screen is.
  addEventListener("beforeprint", () => {
    document.documentElement.dataset.paper = "";
    draw();
  });
  addEventListener("afterprint", () => {
    delete document.documentElement.dataset.paper;
    draw();
  });
  draw();
})();
