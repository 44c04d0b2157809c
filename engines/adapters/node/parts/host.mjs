// The child's side of docs/engine-protocol.md, for engines that run under node.
// An engine's file is started as: node ENGINE.mjs NODE_MODULES
import { createReadStream, readFileSync, writeSync } from 'node:fs';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { pathToFileURL } from 'node:url';

const path = (file) => join(process.argv[2], file);
export const read = (file) => readFileSync(path(file));
export const load = async (file) => { const found = await import(pathToFileURL(path(file))); return found.default ?? found; };
export const version = (name) => JSON.parse(read(`${name}/package.json`)).version;

export const FREE = ['gravity', 'drag', 'torque_body', 'torque_world'];
export const method = (name, summary, more = {}) =>
  ({ name, order: 1, attitude_order: 1, summary, effects: [...FREE, 'pivot'], ...more });
export const xyz = ({ x, y, z }) => [x, y, z];
export const vector = ([x, y, z]) => ({ x, y, z });
const SINGLE = 2 ** -20;                         // some roundings of single precision
const isZero = (v) => v.every((x) => x === 0);

// The scene's torques at an attitude (w x y z) and ω, world axes; null where it has none.
function push({ torque_world: t, torque_body: b, drag }) {
  if (isZero([...t, ...b, drag])) return null;
  const cross = ([x, y, z], v) => [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]];
  return ([w, ...u], omega) => {
    const c = cross(u, b).map((x) => 2 * x), d = cross(u, c);
    return t.map((x, i) => x + b[i] + w * c[i] + d[i] - drag * omega[i]);
  };
}

// Takes steps one by one, each after the scene's torques at the state then.
export const stepped = (scene, state, apply, step) => {
  const torque = push(scene);
  return (steps) => {
    for (let k = 0; k < steps; k++) {
      if (torque) { const { q, omega } = state(); apply(torque(q, omega)); }
      step();
    }
  };
};

// Names of what acts: from gravity and joints as the engine holds them, our own torques, and words for the rest.
export function acting(scene, { gravity, joints, others = {} }) {
  const alike = gravity.every((x, i) => Math.abs(x - scene.gravity[i]) <= SINGLE * Math.hypot(...scene.gravity));
  const found = { [alike ? 'gravity' : `a gravity of ${gravity} m/s²`]: !isZero(gravity), pivot: joints === 1,
    [`${joints} joints`]: joints > 1, drag: scene.drag !== 0, torque_body: !isZero(scene.torque_body),
    torque_world: !isZero(scene.torque_world), ...others };
  return Object.keys(found).filter((name) => found[name]);
}

export async function serve({ open, ...engine }) {
  let session = null;
  const answers = {
    hello: () => ({ protocol: 1, ...engine }),
    open: (call) => { session?.close(); session = open(call.scene, call.method, call.timestep); return { body: session.body(), state: session.state() }; },
    run: ({ steps }) => { session.advance(steps); return session.state(); },
    time: ({ steps }) => { const begun = performance.now(); session.advance(steps); return { seconds: (performance.now() - begun) / 1e3 }; },
    active: () => ({ active: session.active() }),
    close: () => { session?.close(); session = null; return {}; },
  };
  for await (const line of createInterface({ input: createReadStream(null, { fd: 0 }) })) {
    const call = JSON.parse(line);
    let answer;
    try { answer = answers[call.do](call); } catch (error) { answer = { error: String(error).slice(0, 500) }; }
    writeSync(+process.env.SPINCHECK_ANSWERS, JSON.stringify({ id: call.id, ...answer }) + '\n');
  }
}
