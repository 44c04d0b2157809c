// A free rigid body by the explicit midpoint rule: an engine in forty lines (docs/reference/engine-protocol.md).
import { createReadStream, writeSync } from 'node:fs';
import { createInterface } from 'node:readline';

const sum = (a, b, h = 1) => a.map((x, i) => x + h * b[i]);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const times = ([a, b, c, d], [e, f, g, h]) => [a * e - b * f - c * g - d * h,
  a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e];
const turned = ([w, x, y, z], v, way = 1) => {                  // axes to world, or back with -1
  const u = [x * way, y * way, z * way], t = cross(u, v).map((c) => 2 * c);
  return sum(sum(v, t, w), cross(u, t));
};
let scene, h, s;                                                // s: q, then ω in body axes, com, v

const rate = ([q, omega, , v]) => {
  const L = omega.map((w, i) => w * scene.moments[i]);
  let torque = sum(sum(scene.torque_body, turned(q, scene.torque_world, -1)), omega, -scene.drag);
  torque = sum(torque, cross(omega, L), -1);
  return [times(q, [0, ...omega]).map((x) => x / 2), torque.map((t, i) => t / scene.moments[i]), v, scene.gravity];
};
const advance = (steps) => {
  for (let k = 0; k < steps; k++) {
    const moved = (rates, step) => s.map((part, i) => sum(part, rates[i], step));
    s = moved(rate(moved(rate(s), h / 2)), h);
    s[0] = s[0].map((x) => x / Math.hypot(...s[0]));
  }
};
const state = () => ({ q: s[0], omega: turned(s[0], s[1]), com: s[2], velocity: s[3] });
const nonzero = (vector) => vector.some((x) => x !== 0);
const answers = {
  hello: () => ({ protocol: 1, name: 'toy', version: '1.0', precision: 'double', stock_timestep: null, restart: true,
    methods: [{ name: 'midpoint', order: 2, attitude_order: 2, summary: 'explicit midpoint rule',
      effects: ['gravity', 'drag', 'torque_body', 'torque_world'] }] }),
  open: (call) => {
    scene = call.scene;
    return { state: answers.restart({ ...scene, timestep: call.timestep }), body: { mass: scene.mass, com: [0, 0, 0], moments: scene.moments, frame: [1, 0, 0, 0], arm: null } };
  },
  restart: ({ q, omega, com, velocity, timestep }) => {
    h = timestep;
    s = [q, turned(q, omega, -1), com, velocity];
    return state();
  },
  run: ({ steps }) => { advance(steps); return state(); },
  time: ({ steps }) => { const t = performance.now(); advance(steps); return { seconds: (performance.now() - t) / 1e3 }; },
  active: () => ({ active: [['gravity', scene.gravity], ['drag', [scene.drag]], ['torque_body', scene.torque_body],
    ['torque_world', scene.torque_world]].filter(([, v]) => nonzero(v)).map(([name]) => name) }),
  close: () => ({}),
};
for await (const line of createInterface({ input: createReadStream(null, { fd: 0 }) })) {
  const call = JSON.parse(line);
  let answer;
  try { answer = answers[call.do](call); } catch (error) { answer = { error: String(error) }; }
  writeSync(+process.env.SPINCHECK_ANSWERS, JSON.stringify({ id: call.id, ...answer }) + '\n');
}
