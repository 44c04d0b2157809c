// The motions that a page carries, and what is drawn of them: states at any time, the tilt of the
// axis, its path, ω in the body and in space, errors.
Object.assign(spincheck, (() => {
  "use strict";
  // Between two samples a smooth line has so many points.
  const SMOOTH = 4;
  // rad; what the rates at two samples add to an even turn between them, if it is no more.
  const UNEVEN = 1;

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = (matrix, v) => matrix.map((row) => dot(row, v));
  const norm = (v) => Math.sqrt(dot(v, v));
  const norm4 = (q) => Math.hypot(...q);
  const mixed = (a, b, part) => a.map((value, k) => value + part * (b[k] - value));

  function product(a, b) {
    return [
      a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
      a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
      a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
      a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]];
  }

  // Body to world, as rows of a matrix.
  function matrixOf([w, x, y, z]) {
    return [
      [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
  }

  function turned(v) {
    const angle = norm(v), s = angle > 1e-12 ? Math.sin(angle / 2) / angle : 0.5;
    return [Math.cos(angle / 2), s * v[0], s * v[1], s * v[2]];
  }

  // The rotation vector from a to b. Of the rotations that lead there, which differ by whole turns,
  // the one is taken that ω asks for: a fast body turns more than once in between.
  function turnBetween(a, b, wanted) {
    let turn = product([a[0], -a[1], -a[2], -a[3]], b);
    if (turn[0] < 0) turn = turn.map((value) => -value);
    const sine = Math.hypot(turn[1], turn[2], turn[3]);
    if (sine < 1e-9 && norm(wanted) < Math.PI) return turn.slice(1).map((value) => 2 * value);
    const axis = sine > 1e-9
      ? turn.slice(1).map((value) => value / sine) : wanted.map((rate) => rate / norm(wanted));
    const angle = 2 * Math.atan2(sine, turn[0]);
    const whole = 2 * Math.PI * Math.round((dot(wanted, axis) - angle) / (2 * Math.PI));
    return axis.map((value) => value * (angle + whole));
  }

  // The attitude a part of the way from a to b, which has ω before and after as its rates there: an
  // even turn, and what the rates differ from it as a cubic.
  function between(a, b, before, after, seconds, part) {
    const turn = turnBetween(a, b, before.map((rate, k) => (seconds * (rate + after[k])) / 2));
    const excess = (omega) => omega.map((rate, k) => seconds * rate - turn[k]);
    const [e0, e1] = [excess(before), excess(after)], rest = 1 - part;
    const even = product(a, turned(turn.map((value) => part * value)));
    if (Math.max(norm(e0), norm(e1)) > UNEVEN) return even;
    const cubic = e0.map((value, k) => part * rest * (rest * value - part * e1[k]));
    return product(even, turned(cubic));
  }

  class Motion {
    constructor({ t, q, omega_body }) {
      const rows = (columns) => this.t.map((_, k) => columns.map((column) => column[k]));
      this.t = t;
      this.q = rows(q.map(spincheck.restored)).map((one) => one.map((value) => value / norm4(one)));
      this.omega = rows(omega_body.map(spincheck.restored));
    }

    get end() { return this.t[this.t.length - 1]; }

    at(time) {
      const last = this.t.length - 1;
      if (time <= this.t[0] || !last) return { q: this.q[0], omega: this.omega[0] };
      if (time >= this.t[last]) return { q: this.q[last], omega: this.omega[last] };
      let low = 0, high = last;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (this.t[middle] <= time) low = middle; else high = middle;
      }
      const seconds = this.t[high] - this.t[low], part = (time - this.t[low]) / seconds;
      return {
        q: between(this.q[low], this.q[high], this.omega[low], this.omega[high], seconds, part),
        omega: mixed(this.omega[low], this.omega[high], part),
      };
    }

    // A body-fixed unit vector in space at every sample, joined by cubics that have its velocity.
    path(axis) {
      const points = [], speeds = [];
      this.q.forEach((q, k) => {
        const R = matrixOf(q);
        points.push(times(R, axis));
        speeds.push(times(R, cross(this.omega[k], axis)));
      });
      return this.#joined(points, speeds);
    }

    // ω in the body, joined by cubics through the neighbours.
    rates() {
      const { t, omega } = this, last = t.length - 1;
      const speeds = omega.map((_, k) => {
        const a = Math.max(k - 1, 0), b = Math.min(k + 1, last);
        return omega[0].map((_, i) => (b > a ? (omega[b][i] - omega[a][i]) / (t[b] - t[a]) : 0));
      });
      return this.#joined(omega, speeds);
    }

    omegaWorld() {
      const { t, points } = this.rates();
      return { t, points: points.map((omega, k) => times(matrixOf(this.at(t[k]).q), omega)) };
    }

    #joined(points, speeds) {
      const out = { t: [], points: [] };
      this.t.forEach((t, k) => {
        out.t.push(t);
        out.points.push(points[k]);
        if (k + 1 === this.t.length) return;
        const seconds = this.t[k + 1] - t;
        for (let j = 1; j < SMOOTH; j++) {
          const s = j / SMOOTH, s2 = s * s, s3 = s2 * s;
          out.t.push(t + s * seconds);
          out.points.push(points[k].map((value, i) =>
            (2 * s3 - 3 * s2 + 1) * value + (s3 - 2 * s2 + s) * seconds * speeds[k][i] +
            (3 * s2 - 2 * s3) * points[k + 1][i] + (s3 - s2) * seconds * speeds[k + 1][i]));
        }
      });
      return out;
    }
  }

  function decoded(data) {
    const motion = (spec) => new Motion({ ...spec, t: spincheck.restored(spec.t) });
    data.exact = motion(data.exact);
    // The geometry of a motion of many turns is drawn of its first ones, closely.
    data.beginning = data.beginning ? motion(data.beginning) : data.exact;
    for (const run of data.runs) {
      // A run that nobody could tell from the exact motion is drawn as that.
      run.motion = run.q ? motion(run) : data.exact;
      run.t = spincheck.restored(run.t);
      for (const name of ["attitude", "omega", "defect"])
        run[name] = spincheck.restored(run[name]).map((decades) => 10 ** decades);
      run.end = run.t.at(-1);
    }
    return data;
  }

  const degrees = (radians) => (radians * 180) / Math.PI;
  const column = (points, k) => points.map((point) => point[k]);

  // The coordinates of a line: of a run, or where it has no errors of the exact motion.
  const LINES = {
    tilt(motion, run, overlay, body) {
      const { t, points } = motion.path(body.axis);
      const tilt = (p) => degrees(Math.atan2(norm(cross(p, body.up)), dot(p, body.up)));
      return { x: t, y: points.map(tilt) };
    },
    attitude_error: (motion, run) => ({ x: run.t, y: run.attitude.map(degrees) }),
    omega_error: (motion, run) => ({ x: run.t, y: run.omega }),
    defect: (motion, run) => ({ x: run.t, y: run.defect }),
    omega(motion, run, overlay) {
      const { t, points } = motion.rates();
      return { x: t, y: column(points, overlay.component) };
    },
    omega_body(motion, run, overlay) {
      const near = (p) => (norm(p) <= overlay.within ? p : [NaN, NaN, NaN]);
      return solid(motion.rates().points.map((p) => near(times(overlay.matrix, p))));
    },
    omega_world: (motion, run, overlay) =>
      flat(motion.omegaWorld().points.map((p) => times(overlay.matrix, p))),
    axis(motion, run, overlay, body) {
      const points = motion.path(body.axis).points.map((p) => times(overlay.matrix, p));
      return overlay.panel ? flat(points) : solid(points);
    },
    axis_unrolled(motion, run, overlay, body) {
      const points = motion.path(body.axis).points.map((p) => times(overlay.matrix, p));
      let before = 0, turns = 0;
      const azimuths = points.map((p, k) => {
        const azimuth = degrees(Math.atan2(p[1], p[0]));
        if (k) turns -= Math.round((azimuth - before) / 360);
        before = azimuth;
        return azimuth + 360 * turns;
      });
      // Where it jumps, the axis has passed the vertical.
      const x = azimuths.map((value, k) => (k && Math.abs(value - azimuths[k - 1]) > 90 ? NaN : value));
      return { x, y: points.map((p) => degrees(Math.atan2(Math.hypot(p[0], p[1]), p[2]))) };
    },
  };

  const flat = (points) => ({ x: column(points, 0), y: column(points, 1) });
  const solid = (points) => ({ ...flat(points), z: column(points, 2) });

  const place = document.getElementById("packed")?.dataset.motions;
  const motions = place === undefined ? null : decoded(spincheck.items[place]);
  return { motions, lines: LINES, dot, cross, times, norm, matrixOf };
})());
