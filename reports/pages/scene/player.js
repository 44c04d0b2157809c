// Plays the exact motion beside that of a run: bodies drawn as the solid of their inertia, ω and L,
// the path of the axis. Turned by dragging or with the arrow keys.
(() => {
  "use strict";
  const root = document.querySelector(".player");
  const data = spincheck.motions;
  if (!data) return;
  const { dot, cross, times, norm, matrixOf } = spincheck;
  const { body, exact, runs } = data;
  // A turn a frame beyond which a body seems to stand still or to turn backwards.
  const TURN_A_FRAME = 0.5, FRAMES = 60, WHOLE_WINDOW = 12;
  const SECTORS = 16, BELTS = 8;
  const SUPERSCRIPT = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
  const [left, right] = [...root.querySelectorAll("canvas")];
  const find = (name) => root.querySelector(`[data-${name}]`);
  const [choice, play, scrub, clock, speeds, difference] =
    ["run", "play", "time", "clock", "speed", "difference"].map(find);
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const plus = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
  const unit = (v) => v.map((value) => value / (norm(v) || 1));

  // The frame of the page: two level directions and up.
  const across = unit(cross(Math.abs(body.up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], body.up));
  const onwards = cross(body.up, across);
  const camera = { azimuth: 0.6, height: 0.35 };

  const widest = Math.max(...body.half_sides);
  const corner = body.shape === "box" ? norm(body.half_sides) : widest;
  const tip = body.pivot ? Math.max(norm(body.com) + 0.6 * widest, 1.5 * widest) : 1.45 * widest;
  const reach = 1.04 * Math.max(tip, norm(body.com) + corner);
  const largest = { omega: data.fastest || 1, L: 0 };
  const momentum = (omega) => plus(times(body.inertia, omega), body.kept);
  for (const omega of exact.omega) largest.L = Math.max(largest.L, norm(momentum(omega)));
  // Of a top that stays upright the upper half is of interest.
  const tips = exact.path(body.axis);
  const mean = unit(tips.points.reduce((sum, p) => plus(sum, p), [0, 0, 0]));
  const centre = body.pivot ? mean.map((value) => 0.45 * tip * value) : [0, 0, 0];

  const faces = body.shape === "box" ? boxFaces() : ellipsoidFaces();

  function inBody(point) {
    return plus(times(body.R_body_axes, point.map((value, k) => value * body.half_sides[k])), body.com);
  }

  function boxFaces() {
    const made = [];
    for (let k = 0; k < 3; k++)
      for (const side of [-1, 1]) {
        const [u, v] = side > 0 ? [(k + 1) % 3, (k + 2) % 3] : [(k + 2) % 3, (k + 1) % 3];
        const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => {
          const point = [0, 0, 0];
          point[k] = side; point[u] = a; point[v] = b;
          return inBody(point);
        });
        made.push({ corners, tint: side > 0 ? 1 : 0.82 });
      }
    return made;
  }

  // Striped like a beach ball, so that its spin is seen.
  function ellipsoidFaces() {
    const h = body.half_sides;
    const alike = [0, 1, 2].map((k) => Math.abs(h[(k + 1) % 3] - h[(k + 2) % 3]));
    const pole = alike.indexOf(Math.min(...alike)), u = (pole + 1) % 3, v = (pole + 2) % 3;
    const at = (i, j) => {
      const polar = (Math.PI * i) / BELTS, around = (2 * Math.PI * j) / SECTORS, point = [0, 0, 0];
      point[pole] = Math.cos(polar);
      point[u] = Math.sin(polar) * Math.cos(around);
      point[v] = Math.sin(polar) * Math.sin(around);
      return inBody(point);
    };
    const made = [];
    for (let i = 0; i < BELTS; i++)
      for (let j = 0; j < SECTORS; j++)
        made.push({
          corners: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
          tint: (j >> 1) % 2 ? 0.72 : 1,
        });
    return made;
  }

  function view(canvas) {
    const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const level = plus(across.map((x) => x * Math.cos(camera.azimuth)), onwards, Math.sin(camera.azimuth));
    const towards = plus(level.map((x) => x * Math.cos(camera.height)), body.up, Math.sin(camera.height));
    const sideways = unit(cross(body.up, level)), upwards = cross(towards, sideways);
    const scale = Math.min(width, height) / 2 / reach;
    const place = (p) => {
      const from = plus(p, centre, -1);
      return [width / 2 + scale * dot(from, sideways), height / 2 - scale * dot(from, upwards)];
    };
    return { pen, place, towards, light: unit(plus(plus(towards, body.up, 0.8), sideways, -0.5)) };
  }

  function stroke({ pen, place }, points, ink, width, opacity = 1) {
    pen.beginPath();
    points.forEach((p, k) => (k ? pen.lineTo(...place(p)) : pen.moveTo(...place(p))));
    Object.assign(pen, { strokeStyle: ink, lineWidth: width, globalAlpha: opacity, lineJoin: "round" });
    pen.stroke();
    pen.globalAlpha = 1;
  }

  function arrow(seen, from, vector, ink, name, aside = 7) {
    if (norm(vector) < 0.02 * reach) return;
    const { pen, place } = seen;
    const [x0, y0] = place(from), [x, y] = place(plus(from, vector));
    const length = Math.hypot(x - x0, y - y0);
    stroke(seen, [from, plus(from, vector)], ink, 3);
    if (length > 9) {
      const a = (x - x0) / length, b = (y - y0) / length;
      pen.beginPath();
      pen.moveTo(x + 3 * a, y + 3 * b);
      pen.lineTo(x - 8 * a - 5 * b, y - 8 * b + 5 * a);
      pen.lineTo(x - 8 * a + 5 * b, y - 8 * b - 5 * a);
      pen.fillStyle = ink;
      pen.fill();
    }
    pen.fillStyle = ink;
    pen.font = "italic 600 16px system-ui, sans-serif";
    pen.fillText(name, x + aside, y - 5);
  }

  // Convex, so that faces turned away are all that is hidden.
  function solid({ pen, place, towards, light }, R, ink) {
    for (const face of faces) {
      const corners = face.corners.map((corner) => times(R, corner));
      let normal = cross(plus(corners[2], corners[0], -1), plus(corners[3], corners[1], -1));
      const middle = corners.reduce((sum, p) => plus(sum, p, 0.25), [0, 0, 0]);
      if (dot(normal, plus(middle, times(R, body.com), -1)) < 0) normal = normal.map((value) => -value);
      normal = unit(normal);
      if (dot(normal, towards) <= 0) continue;
      const shade = face.tint * (0.45 + 0.55 * Math.max(0, dot(normal, light)));
      pen.beginPath();
      corners.forEach((p, k) => (k ? pen.lineTo(...place(p)) : pen.moveTo(...place(p))));
      pen.closePath();
      pen.fillStyle = `color-mix(in srgb, ${ink} ${Math.round(100 * shade)}%, black)`;
      pen.strokeStyle = pen.fillStyle;
      pen.lineWidth = 0.6;
      pen.fill();
      pen.stroke();
    }
  }

  function drawn(canvas, motion, trail, time, ink) {
    const seen = view(canvas), { q, omega } = motion.at(time), R = matrixOf(q);
    const com = times(R, body.com), axis = times(R, body.axis);
    const path = trail.points.filter((_, k) => trail.t[k] <= time).map((p) => p.map((x) => tip * x));
    if (canvas === right) stroke(seen, tips.points.map((p) => p.map((x) => tip * x)), colour("--muted"), 1, 0.35);
    stroke(seen, [...path, axis.map((x) => tip * x)], ink, 1.8, 0.9);
    const end = axis.map((x) => tip * x), facing = dot(axis, seen.towards) > 0;
    const shaft = [body.pivot ? [0, 0, 0] : end.map((x) => -x), end];
    if (!facing || body.pivot) stroke(seen, shaft, colour("--ink"), 2);
    solid(seen, R, ink);
    if (facing) stroke(seen, [plus(com, axis, 0), end], colour("--ink"), 2);
    if (body.pivot) stroke(seen, [[0, 0, 0], plus([0, 0, 0], body.up, -0.06 * reach)], colour("--ink"), 5);
    // L is drawn shorter, so that both are seen where they are parallel.
    const of = (vector, most) => vector.map((x) => (0.85 * reach * x) / most);
    const origin = body.pivot ? [0, 0, 0] : com;
    arrow(seen, origin, of(times(R, omega), largest.omega), colour("--vector-omega"), "ω");
    arrow(seen, origin, of(times(R, momentum(omega)), 1.4 * largest.L || 1), colour("--vector-L"), "L", -18);
  }

  let time = 0, playing = false, before = 0, run = runs[0], trail = run && run.motion.path(body.axis);

  const significant = (value) => Number(value.toPrecision(3)).toString();

  // At the time shown, between samples of the run on a line.
  function attitudeError() {
    if (!run) return "";
    if (time >= run.end && run.outcome !== "ok")
      return `${run.outcome} at ${significant(run.stopped_at ?? run.end)} s`;
    const after = run.t.findIndex((t) => t > time), last = run.t.length - 1;
    const k = after < 0 ? last : Math.max(after - 1, 0), next = Math.min(k + 1, last);
    const part = next > k ? (time - run.t[k]) / (run.t[next] - run.t[k]) : 0;
    const error = run.attitude[k] + part * (run.attitude[next] - run.attitude[k]);
    if (Number.isNaN(error)) return "";
    // What is rounded to the uncertainty is not above it.
    const bound = error < run.uncertainty * 1.01 ? "≤ " : "";
    return `attitude error ${bound}${degrees((error * 180) / Math.PI)}`;
  }

  function degrees(angle) {
    if (angle >= 0.01) return `${Number(angle.toPrecision(2))}°`;
    const [mantissa, exponent] = angle.toExponential(1).split("e");
    return `${mantissa}×10${[...exponent].map((c) => SUPERSCRIPT[c] ?? "").join("")}°`;
  }

  function draw() {
    drawn(left, exact, tips, time, colour("--exact-body"));
    if (run) drawn(right, run.motion, trail, time, run.look[0]);
    scrub.value = time / data.duration;
    clock.textContent = `${significant(time)} of ${significant(data.duration)} s`;
    scrub.setAttribute("aria-valuetext", clock.textContent);
    difference.textContent = attitudeError();
  }

  function frame(now) {
    if (!playing) return;
    time = Math.min(data.duration, time + (Math.min(now - before, 100) / 1000) * Number(speeds.value));
    before = now;
    if (time >= data.duration) toggle(false);
    draw();
    requestAnimationFrame(frame);
  }

  function toggle(wanted) {
    playing = wanted;
    play.textContent = playing ? "❚❚ Pause" : "▶ Play";
    play.setAttribute("aria-pressed", String(playing));
    if (!playing) return;
    if (time >= data.duration) time = 0;
    before = performance.now();
    requestAnimationFrame(frame);
  }

  function offered() {
    const usual = Math.min(data.duration / WHOLE_WINDOW, (FRAMES * TURN_A_FRAME) / (data.fastest || 1e-9));
    const power = Math.floor(Math.log2(usual));
    for (let k = power - 3; k <= power + 3; k++) {
      const speed = 2 ** k;
      const name = k < 0 && k > -11 ? `1/${2 ** -k}` : significant(speed);
      speeds.append(new Option(`${name} × real time`, String(speed), k === power, k === power));
    }
    runs.forEach((one, k) => choice.append(new Option(one.name, String(k))));
    if (!runs.length) return;
    choice.value = String(data.first);
    choose(data.first);
  }

  function choose(k) {
    run = runs[k];
    trail = run && run.motion.path(body.axis);
  }

  function turn(azimuth, height) {
    camera.azimuth += azimuth;
    camera.height = Math.max(-1.5, Math.min(1.5, camera.height + height));
    draw();
  }

  for (const canvas of [left, right]) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) turn(-event.movementX / 90, event.movementY / 90);
    });
    canvas.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      if (by) turn(...by);
      else if (event.key === " ") toggle(!playing);
      else return;
      event.preventDefault();
    });
  }
  play.addEventListener("click", () => toggle(!playing));
  scrub.addEventListener("input", () => { time = scrub.value * data.duration; draw(); });
  choice.addEventListener("change", () => { choose(Number(choice.value)); draw(); });
  new ResizeObserver(draw).observe(left);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  offered();
  draw();
})();
