// The first screen's table: draws, colours, filters and sorts the runs that the page carries.
(() => {
  "use strict";
  const data = spincheck.items[document.getElementById("packed").dataset.heat];
  const table = document.getElementById("heat");
  const detail = document.getElementById("detail");
  // Angles are shown in degrees.
  const SIGNALS = data.signals.map((signal) =>
    signal.unit === "rad"
      ? { ...signal, title: `${signal.label} error, degrees`, low: -8, high: 2, factor: 180 / Math.PI, suffix: "°" }
      : { ...signal, title: `${signal.label} error, relative`, low: -12, high: 0 },
  );
  const COST = { name: "cost", title: "CPU seconds a simulated second", low: -5, high: -1 };
  const AT = { stock: "stock timestep", common: "1 ms", finest: "finest timestep" };
  // Monotone in lightness, so that they tell without hue: YlOrRd of ColorBrewer on white, and
  // inferno (van der Walt and Smith) on black; a larger error stands out more.
  const LIGHT = ["#ffffe5", "#fff3b2", "#fee187", "#fec561", "#fd9f44", "#fb7434", "#ee3423", "#c20325", "#800026"];
  const DARK = ["#1f1235", "#320a5e", "#57106e", "#7c1d6d", "#a32c61", "#c83f4b", "#e65d2f", "#f8850f", "#fcc22c"];
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const checked = (name) => document.querySelector(`.controls input[name=${name}]:checked`).value;
  const state = { signal: checked("signal"), at: checked("at"), find: "", kind: "", tag: "", engine: "", verdict: "", methods: "all", sort: null, up: false };
  // What of it the address carries, as name=value after the #.
  const ADDRESSED = ["signal", "at", "find", "kind", "tag", "engine", "verdict"];
  const atFirst = { ...state };
  // More columns do not fit a window; of each engine two are shown then, unless all are asked for.
  const MOST_COLUMNS = 14;
  const open = new Set();

  function element(tag, text, attributes = {}) {
    const made = document.createElement(tag);
    if (text !== undefined) made.textContent = text;
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return made;
  }

  // ---- numbers
  const SUPERSCRIPT = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
  function number(value, digits = 2) {
    if (value === 0) return "0";
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    if (exponent >= -2 && exponent < 3) return String(Number(value.toPrecision(Math.max(digits, +exponent + 1))));
    return `${mantissa}×10${[...String(+exponent)].map((c) => SUPERSCRIPT[c]).join("")}`;
  }
  // In a cell: what stands with a power of ten has one digit, or the table would not fit a window.
  const short = (value) => number(value, value < 0.01 ? 1 : 2);
  const quantity = () => SIGNALS.find((signal) => signal.name === state.signal) ?? COST;
  // What a run shows: its number, whether it is a bound, and null where it has none.
  function valueOf(run) {
    if (!run?.errors) return null;
    // Without an error in what its scene lacks, such as spins.
    const value = quantity() === COST ? run.cost : run.errors[state.signal] ?? null;
    return value === null ? null : Math.abs(value) * (quantity().factor ?? 1);
  }
  function isBound(run) {
    return quantity() !== COST && (run.errors[state.signal] < 0 || Object.is(run.errors[state.signal], -0));
  }

  // ---- colours
  function paint(cell, value) {
    const { low, high } = quantity();
    const place = value > 0 ? (Math.log10(value) - low) / (high - low) : 0;
    const ramp = dark.matches ? DARK : LIGHT;
    const index = Math.round(Math.min(Math.max(place, 0), 1) * (ramp.length - 1));
    cell.style.background = ramp[index];
    const lightest = dark.matches ? index > 5 : index < 6;
    cell.style.color = lightest ? "#1b1f24" : "#ffffff";
  }

  // ---- cells
  function said(run, name) {
    if (!run) return "not run";
    if (!run.errors) {
      const when = run.when === null ? "" : ` at ${number(run.when, 3)} s`;
      return `${number(run.timestep, 3)} s: ${run.outcome}${when}: ${run.why}`;
    }
    const errors = SIGNALS.filter((signal) => signal.name in run.errors).map((signal) => {
      if (run.errors[signal.name] === null) return `${signal.label} ∞`;
      const value = Math.abs(run.errors[signal.name]) * (signal.factor ?? 1);
      const bound = run.errors[signal.name] < 0 ? "≤ " : "";
      return `${signal.label} ${bound}${number(value, 3)}${signal.suffix ?? ""}`;
    });
    const cost = run.cost === null ? "" : `; ${number(run.cost, 3)} CPU s a simulated second`;
    return `${name}${number(run.timestep, 3)} s: ${errors.join(", ")}${cost}`;
  }
  function linked(cell, href, text, tell) {
    const link = element("a", text, { href, tabindex: "-1" });
    link.tell = tell;
    cell.append(link);
    return cell;
  }
  function runCell(scene, column, cell) {
    const td = element("td");
    if (!cell) {
      td.className = "absent";
      td.textContent = "not run";
      return td;
    }
    const { verdict } = cell;
    const run = cell.runs[state.at];
    const sign = verdict && verdict !== "converges" ? `${data.verdicts[verdict].sign} ` : "";
    const value = valueOf(run);
    let text;
    if (value !== null) {
      text = `${sign}${isBound(run) ? "≤ " : ""}${short(value)}${quantity().suffix ?? ""}`;
      paint(td, value);
    } else if (run?.outcome) {
      td.className = run.outcome;
      text = run.outcome === "diverged" && run.when !== null ? `↗ ${number(run.when)} s` : run.outcome === "unsupported" ? "n/a" : `! ${run.outcome}`;
    } else {
      td.className = verdict || "absent";
      text = verdict === "unsupported" ? "–" : run ? "—" : `${sign}—`;
    }
    const where = `${scene.name}, ${column.engine} ${column.method}`;
    const about = run ? said(run, "") : verdict === "unsupported" ? "" : `no run at the ${AT[state.at]}`;
    const parts = [where, about, verdict || "no verdict"].filter(Boolean);
    return linked(td, `${scene.page}#${column.anchor}`, text, parts.join(" · "));
  }
  // The best of all engines, or of the one that is chosen.
  const bestOf = (scene) => scene.best.find((best) => !state.engine || best.engine === state.engine);
  function bestCell(scene) {
    const td = element("td", undefined, { class: "best" });
    const best = bestOf(scene);
    if (!best) {
      td.classList.add("absent");
      return linked(td, scene.page, "nothing", `${scene.name} · ${scene.none || `${state.engine}: no method converges`}`);
    }
    const value = valueOf(best.run);
    const shown = value === null ? "—" : `${isBound(best.run) ? "≤ " : ""}${short(value)}${quantity().suffix ?? ""}`;
    const chip = element("span", shown, { class: "chip-number" });
    if (value !== null) paint(chip, value);
    const price = best.price === null ? "" : `, ${number(best.price)}×`;
    const description = [
      `${scene.name}, ${best.within ? "the cheapest run within 0.1° and 10⁻³ in ω" : "the most accurate run: none is within 0.1° and 10⁻³ in ω"}`,
      `${best.label} at ${said(best.run, "")}`,
      best.price === null ? "" : `${number(best.price)} times the CPU time of ${best.default} as shipped`,
    ];
    linked(td, `${scene.page}#${best.anchor}`, "", description.filter(Boolean).join(" · "));
    const words = element("span");
    words.append(element("span", best.label), " ", element("span", `${best.timestep}${price}`));
    td.firstChild.append(chip, words);
    return td;
  }
  function sceneRow(scene, columns, nested) {
    const row = element("tr");
    const head = element("th", undefined, { scope: "row", title: scene.title });
    if (nested) head.className = "nested";
    row.append(linked(head, scene.page, scene.name, scene.title));
    for (const { column, index } of columns) row.append(runCell(scene, column, scene.cells[index]));
    row.append(bestCell(scene));
    return row;
  }

  // ---- hard scenes, folded by kind
  function median(values) {
    const sorted = [...values].sort((a, b) => a - b);
    return sorted[Math.floor(sorted.length / 2)];
  }
  function foldedRow(kind, scenes, columns) {
    const row = element("tr", undefined, { class: "folded" });
    const head = element("th", undefined, { scope: "row" });
    const expanded = open.has(kind);
    const button = element("button", `${expanded ? "▾" : "▸"} hard: ${kind.toLowerCase()} (${scenes.length})`, {
      type: "button", "aria-expanded": String(expanded),
    });
    button.addEventListener("click", () => {
      if (!open.delete(kind)) open.add(kind);
      draw();
      [...table.querySelectorAll(".folded button")].find((b) => b.textContent.includes(`: ${kind.toLowerCase()} (`))?.focus();
    });
    head.append(button);
    row.append(head);
    for (const { column, index } of columns) {
      const cells = scenes.map((scene) => scene.cells[index]).filter((cell) => cell && cell.verdict !== "unsupported");
      const td = element("td");
      // A run that blew up is worse than any number; one that was not made is not counted.
      const values = cells
        .filter((cell) => cell.runs[state.at] && cell.runs[state.at].outcome !== "unsupported")
        .map((cell) => valueOf(cell.runs[state.at]) ?? Infinity);
      const middle = median(values);
      const good = cells.filter((cell) => cell.verdict === "converges").length;
      td.textContent = middle === undefined ? "–" : middle === Infinity ? "↗" : `${short(middle)}${quantity().suffix ?? ""}`;
      if (middle < Infinity) paint(td, middle);
      td.append(element("small", cells.length ? `✓ ${good}/${cells.length}` : ""));
      td.title = `${column.engine} ${column.method}: median of ${values.length} runs; converges on ${good} of ${cells.length}`;
      row.append(td);
    }
    const within = scenes.filter((scene) => bestOf(scene)?.within).length;
    row.append(element("td", `within 0.1° on ${within} of ${scenes.length}`, { class: "best" }));
    return row;
  }

  // ---- rows shown
  function matches(scene, columns) {
    const text = `${scene.name} ${scene.title}`.toLowerCase();
    if (!state.find.toLowerCase().split(/\s+/).every((word) => text.includes(word))) return false;
    if (state.kind && scene.kind !== state.kind) return false;
    if (state.tag && !scene.tags.includes(state.tag)) return false;
    return !state.verdict || columns.some(({ index }) => scene.cells[index]?.verdict === state.verdict);
  }
  function key(scene) {
    if (state.sort === "scene") return scene.name;
    if (state.sort === "best") return bestOf(scene) ? (valueOf(bestOf(scene).run) ?? Infinity) : Infinity;
    const cell = scene.cells[state.sort];
    if (!cell || cell.verdict === "unsupported") return null;
    const run = cell.runs[state.at];
    if (!run || run.outcome === "unsupported") return null;
    return valueOf(run) ?? 1e300 * (1 + (data.verdicts[cell.verdict]?.rank ?? 0));
  }
  function sorted(scenes) {
    if (state.sort === null) return scenes;
    const keyed = scenes.map((scene) => [key(scene), scene]);
    const way = state.up ? 1 : -1;
    keyed.sort(([a], [b]) => {
      // What was not run comes last, whichever way.
      if (a === null || b === null) return (a === null) - (b === null);
      return a < b ? -way : a > b ? way : 0;
    });
    return keyed.map(([, scene]) => scene);
  }
  // In place of the rows: why there is none, and the way back.
  function nothingFound(columns) {
    const filters = ["find", "kind", "tag", "verdict"].filter((name) => state[name]);
    const row = element("tr", undefined, { class: "none" });
    const cell = element("td", `No scene matches ${filters.map((name) => `${name} “${state[name]}”`).join(" and ")}. `, { colspan: String(columns.length + 2) });
    const button = element("button", "Show all scenes", { type: "button" });
    button.addEventListener("click", () => {
      for (const name of filters) state[name] = document.getElementById(name).value = "";
      draw();
    });
    cell.append(button);
    row.append(cell);
    return row;
  }
  function body(columns) {
    const shown = data.scenes.filter((scene) => matches(scene, columns));
    const folding = !(state.find || state.tag || state.verdict);
    const plain = folding ? shown.filter((scene) => !scene.hard) : shown;
    const rows = [];
    if (state.sort === null) {
      for (const kind of data.kinds) {
        const scenes = plain.filter((scene) => scene.kind === kind);
        if (!scenes.length) continue;
        const heading = element("tr", undefined, { class: "kind" });
        heading.append(element("th", kind, { scope: "rowgroup", colspan: String(columns.length + 2) }));
        rows.push(heading, ...scenes.map((scene) => sceneRow(scene, columns)));
      }
    } else rows.push(...sorted(plain).map((scene) => sceneRow(scene, columns)));
    for (const kind of folding ? data.kinds : []) {
      const hard = shown.filter((scene) => scene.hard && scene.kind === kind);
      if (!hard.length) continue;
      rows.push(foldedRow(kind, hard, columns));
      if (open.has(kind)) rows.push(...sorted(hard).map((scene) => sceneRow(scene, columns, true)));
    }
    if (!shown.length) rows.push(nothingFound(columns));
    const total = data.scenes.length;
    document.getElementById("shown").textContent =
      `${shown.length === total ? total : `${shown.length} of ${total}`} scene${total === 1 ? "" : "s"}`;
    return rows;
  }

  // ---- headings
  function heading(label, sort, note) {
    const th = element("th", undefined, { scope: "col" });
    const active = state.sort === sort;
    th.setAttribute("aria-sort", active ? (state.up ? "ascending" : "descending") : "none");
    const button = element("button", label, { type: "button", "data-sort": String(sort) });
    if (note) button.append(element("small", note));
    if (active) button.append(element("span", state.up ? " ▲" : " ▼"));
    button.addEventListener("click", () => {
      if (state.sort !== sort) [state.sort, state.up] = [sort, sort === "scene"];
      else if (state.up === (sort === "scene")) state.up = !state.up;
      else state.sort = null;
      draw();
      table.querySelector(`[data-sort="${sort}"]`).focus();
    });
    th.append(button);
    return th;
  }
  function head(columns) {
    const engines = element("tr");
    engines.append(element("th"));
    let last = null;
    for (const { column } of columns) {
      const group = column.shipped ? "as shipped" : column.engine;
      if (last && last.textContent === group) last.colSpan += 1;
      else engines.append((last = element("th", group, { scope: "colgroup", class: "group" })));
    }
    engines.append(element("th", "best choice", { class: "group", title: "The cheapest run within 0.1° in attitude and 10⁻³ in ω, of the methods that converge" }));
    const methods = element("tr");
    methods.append(heading("scene", "scene"));
    for (const { column, index } of columns) {
      const note = state.at === "stock" ? column.stock : state.at === "common" ? AT.common : "";
      methods.append(heading(column.label, index, note));
    }
    methods.append(heading("cheapest run within 0.1°", "best", "timestep, CPU time of the default"));
    return [engines, methods];
  }

  function draw() {
    const columns = data.columns
      .map((column, index) => ({ column, index }))
      .filter(({ column }) => !state.engine || column.engine === state.engine)
      .filter(({ column }) => state.engine || state.methods === "all" || column.leading);
    const thead = element("thead");
    thead.append(...head(columns));
    const tbody = element("tbody");
    tbody.append(...body(columns));
    table.replaceChildren(thead, tbody);
    const first = tbody.querySelector("a");
    if (first) first.tabIndex = 0;
    scale();
    explain(columns);
    address();
  }
  // The signs that the table shows, in words.
  function explain(columns) {
    const cells = data.scenes.flatMap((scene) => columns.map(({ index }) => scene.cells[index])).filter(Boolean);
    const runs = cells.map((cell) => cell.runs[state.at]);
    const given = new Set(cells.map((cell) => cell.verdict));
    const parts = Object.entries(data.verdicts)
      .filter(([word, { needs_reason }]) => needs_reason && given.has(word))
      .map(([word, { sign }]) => `${sign} before a number: the verdict is '${word}'`);
    if (runs.some((run) => run?.outcome === "diverged")) parts.push("↗ 2.8 s: this run blew up at 2.8 s");
    const lost = runs.find((run) => run?.outcome && !["diverged", "unsupported"].includes(run.outcome));
    if (lost) parts.push(`! ${lost.outcome}: this run gave no motion to compare`);
    if (runs.some((run) => run?.outcome === "unsupported")) parts.push("n/a: not run at this timestep");
    if (given.has("unsupported")) parts.push("–: the engine cannot simulate the scene");
    if (runs.some((run) => run?.errors && Object.values(run.errors).some((error) => error < 0 || Object.is(error, -0))))
      parts.push("≤: as close as the exact motion is known");
    document.getElementById("signs").textContent = parts.join(" · ");
  }
  function address() {
    const changed = ADDRESSED.filter((name) => state[name] !== atFirst[name]);
    const filters = new URLSearchParams(changed.map((name) => [name, state[name]])).toString();
    if (filters || location.hash.includes("=")) history.replaceState(null, "", `#${filters}`);
  }
  // The filters of an address; what this table does not offer is passed over.
  function readAddress() {
    const filters = new URLSearchParams(location.hash.slice(1));
    for (const name of ADDRESSED) {
      if (!filters.has(name)) continue;
      const value = filters.get(name);
      const radio = [...document.querySelectorAll(`.controls input[name=${name}]`)].find((input) => input.value === value);
      const control = document.getElementById(name);
      if (radio) radio.checked = true;
      else if (control) control.value = value;
      state[name] = radio || control?.value === value ? value : atFirst[name];
    }
  }
  function scale() {
    const { title, low, high, suffix = "" } = quantity();
    const power = (exponent) => (exponent === 0 ? "1" : exponent === 2 ? "100" : number(10 ** exponent, 1).replace("1×", ""));
    document.getElementById("unit").textContent = `${title}:`;
    document.getElementById("low").textContent = `${power(low)}${suffix}`;
    document.getElementById("high").textContent = `${power(high)}${suffix}`;
    const ramp = (dark.matches ? DARK : LIGHT).map((colour) => {
      const box = element("i");
      box.style.background = colour;
      return box;
    });
    document.getElementById("ramp").replaceChildren(...ramp);
  }

  // ---- controls
  function offer(id, values, all) {
    const select = document.getElementById(id);
    select.append(element("option", all, { value: "" }), ...values.map((value) => element("option", value, { value })));
    select.addEventListener("change", () => {
      state[id] = select.value;
      draw();
    });
  }
  const unique = (values) => [...new Set(values)];
  offer("kind", data.kinds.filter((kind) => data.scenes.some((scene) => scene.kind === kind)), "all");
  offer("tag", unique(data.scenes.flatMap((scene) => scene.tags)).sort(), "all");
  offer("engine", unique(data.columns.map((column) => column.engine)), "all");
  offer("verdict", Object.keys(data.verdicts).filter((word) => data.scenes.some((s) => s.cells.some((c) => c?.verdict === word))), "any");
  if (data.columns.length > MOST_COLUMNS) {
    state.methods = "";
    const select = document.getElementById("methods-shown");
    select.append(element("option", "as shipped, and each engine's best", { value: "" }), element("option", "all methods", { value: "all" }));
    select.addEventListener("change", () => {
      state.methods = select.value;
      draw();
    });
    select.parentElement.hidden = false;
  }
  document.getElementById("find").addEventListener("input", (event) => {
    state.find = event.target.value.trim();
    draw();
  });
  for (const input of document.querySelectorAll(".controls input[type=radio]"))
    input.addEventListener("change", () => {
      state[input.name] = input.value;
      draw();
    });

  // ---- pointer and keyboard
  function tell(event) {
    const link = event.target.closest?.("#heat td, #heat th")?.querySelector("a");
    if (link?.tell) detail.textContent = link.tell;
  }
  table.addEventListener("mouseover", tell);
  table.addEventListener("focusin", tell);
  const MOVES = { ArrowDown: [1, 0], ArrowUp: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] };
  table.addEventListener("keydown", (event) => {
    const move = MOVES[event.key];
    const from = event.target.closest("td, tbody th");
    if (!move || !from) return;
    const rows = [...table.tBodies[0].rows];
    let [r, c] = [rows.indexOf(from.parentElement), from.cellIndex];
    do {
      r += move[0];
      c += move[1];
    } while (rows[r]?.cells[c] === undefined ? rows[r] && move[0] : !rows[r].cells[c].querySelector("a, button"));
    const target = rows[r]?.cells[c]?.querySelector("a, button");
    if (!target) return;
    event.preventDefault();
    table.querySelector("tbody a[tabindex='0']")?.setAttribute("tabindex", "-1");
    if (target.tagName === "A") target.tabIndex = 0;
    target.focus();
  });

  dark.addEventListener("change", draw);
  addEventListener("hashchange", () => {
    if (!location.hash.includes("=")) return;
    readAddress();
    draw();
  });
  readAddress();
  draw();
})();
