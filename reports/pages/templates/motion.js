// What a page carries, unpacked: figures, folded tables, and motions with what is drawn of them:
// states at any time, the tilt of the axis, its path, ω in the body and in space, errors.
const spincheck = (() => {
  "use strict";
  const FULL = 32767;
  // As in motion_data.py: decades of errors, in steps; the last number is a gap.
  const LOWEST_DECADE = -20, DECADES = 30, GAP = 4095;
  // Between two samples a smooth line has so many points.
  const SMOOTH = 4;

  function bytes(text) {
    const raw = atob(text);
    const out = new Uint8Array(raw.length);
    for (let k = 0; k < raw.length; k++) out[k] = raw.charCodeAt(k);
    return out.buffer;
  }

  function errors(text) {
    return Array.from(new Uint16Array(bytes(text)), (step) =>
      step === GAP ? NaN : 10 ** (LOWEST_DECADE + (DECADES * step) / (GAP - 1)));
  }

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = (matrix, v) => matrix.map((row) => dot(row, v));
  const norm = (v) => Math.sqrt(dot(v, v));
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

  // The attitude a part of the way from a to b. Of the rotations that lead there, which differ by
  // whole turns, the one is taken that ω asks for: a fast body turns more than once in between.
  function between(a, b, omega, seconds, part) {
    let turn = product([a[0], -a[1], -a[2], -a[3]], b);
    if (turn[0] < 0) turn = turn.map((value) => -value);
    const sine = Math.hypot(turn[1], turn[2], turn[3]);
    const wanted = omega.map((rate) => rate * seconds);
    let axis, angle;
    if (sine > 1e-9) {
      axis = [turn[1] / sine, turn[2] / sine, turn[3] / sine];
      angle = 2 * Math.atan2(sine, turn[0]);
    } else {
      const size = norm(wanted) || 1;
      axis = wanted.map((value) => value / size);
      angle = 0;
    }
    angle += 2 * Math.PI * Math.round((dot(wanted, axis) - angle) / (2 * Math.PI));
    const half = (part * angle) / 2, s = Math.sin(half);
    return product(a, [Math.cos(half), s * axis[0], s * axis[1], s * axis[2]]);
  }

  class Motion {
    // Of the exact motion single precision, of a run 16 bits.
    constructor(spec, t, Values, whole) {
      this.t = t;
      const q = new Values(bytes(spec.q)), w = new Values(bytes(spec.omega_body));
      this.q = t.map((_, k) => {
        const one = Array.from(q.subarray(4 * k, 4 * k + 4)), size = Math.hypot(...one);
        return one.map((value) => value / size);
      });
      this.omega = t.map((_, k) =>
        Array.from(w.subarray(3 * k, 3 * k + 3), (value) => (value / whole) * spec.largest));
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
      const mean = mixed(this.omega[low], this.omega[high], 0.5);
      return {
        q: between(this.q[low], this.q[high], mean, seconds, part),
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

  // The items of the page, by number.
  async function unpacked() {
    const element = document.getElementById("packed");
    if (!element) return null;
    const deflated = new Blob([bytes(element.textContent.trim())]).stream();
    const items = await new Response(deflated.pipeThrough(new DecompressionStream("deflate"))).json();
    const motions = "motions" in element.dataset ? decoded(items[element.dataset.motions]) : null;
    return { items, motions };
  }

  function decoded(data) {
    const bases = data.times.map((text) => Array.from(new Float32Array(bytes(text))));
    data.exact = new Motion(data.exact, bases[data.exact.t], Float32Array, 1);
    for (const run of data.runs) {
      run.t = bases[run.t];
      // A run that nobody could tell from the exact motion is drawn as that.
      run.motion = run.q ? new Motion(run, run.t, Int16Array, FULL) : data.exact;
      run.attitude = errors(run.attitude);
      run.omega = errors(run.omega);
      run.end = run.t[run.t.length - 1];
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
      const x = points.map((p, k) => {
        const azimuth = degrees(Math.atan2(p[1], p[0]));
        if (k) turns -= Math.round((azimuth - before) / 360);
        before = azimuth;
        return azimuth + 360 * turns;
      });
      return { x, y: points.map((p) => degrees(Math.atan2(Math.hypot(p[0], p[1]), p[2]))) };
    },
  };

  const flat = (points) => ({ x: column(points, 0), y: column(points, 1) });
  const solid = (points) => ({ ...flat(points), z: column(points, 2) });

  return { packed: unpacked(), lines: LINES, dot, cross, times, norm, matrixOf };
})();
