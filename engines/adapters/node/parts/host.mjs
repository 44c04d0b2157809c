// The child's side of docs/reference/engine-protocol.md, for engines that run under node.
// An engine's file is started as: node ENGINE.mjs NODE_MODULES
import { createReadStream, writeSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { read } from './building.mjs';

export const version = (name) => JSON.parse(read(`${name}/package.json`)).version;

export const FREE = ['gravity', 'drag', 'torque_body', 'torque_world'];
export const method = (name, summary, more = {}) =>
  ({ name, order: 1, attitude_order: 1, summary, effects: [...FREE, 'pivot'], ...more });
const SINGLE = 2 ** -20;                         // some roundings of single precision
const isZero = (v) => v.every((x) => x === 0);

// Names of what acts: from gravity and joints as the engine holds them, our own torques, and words for the rest.
function acting(scene, { gravity, joints, others = {} }) {
  const alike = gravity.every((x, i) => Math.abs(x - scene.gravity[i]) <= SINGLE * Math.hypot(...scene.gravity));
  const found = { [alike ? 'gravity' : `a gravity of ${gravity} m/s²`]: !isZero(gravity), pivot: joints === 1,
    [`${joints} joints`]: joints > 1, drag: scene.drag !== 0, torque_body: !isZero(scene.torque_body),
    torque_world: !isZero(scene.torque_world), ...others };
  return Object.keys(found).filter((name) => found[name]);
}

// An engine has open(scene, method, timestep) → what it holds, with state, advance, close; and of what it holds
// body(held, scene), and acts(held, scene): gravity, joints, others.
export async function serve({ open, body, acts, ...engine }) {
  let held = null, opened = null, scene = null;
  // A world is built in less time than an engine takes to forget: a restart is a new one.
  const build = (call) => { held?.close(); opened = call; scene = call.scene; held = open(scene, call.method, call.timestep); };
  const answers = {
    hello: () => ({ protocol: 1, restart: true, ...engine }),
    open: (call) => { build(call); return { body: body(held, scene), state: held.state() }; },
    restart: ({ q, omega, com, velocity, timestep }) => {
      build({ ...opened, timestep, scene: { ...scene, q, omega, com, velocity } }); return held.state(); },
    run: ({ steps }) => { held.advance(steps); return held.state(); },
    time: ({ steps }) => { const begun = performance.now(); held.advance(steps); return { seconds: (performance.now() - begun) / 1e3 }; },
    active: () => ({ active: acting(scene, acts(held, scene)) }),
    close: () => { held?.close(); held = null; return {}; },
  };
  for await (const line of createInterface({ input: createReadStream(null, { fd: 0 }) })) {
    const call = JSON.parse(line);
    let answer;
    try { answer = answers[call.do](call); } catch (error) { answer = { error: String(error).slice(0, 500) }; }
    writeSync(+process.env.SPINCHECK_ANSWERS, JSON.stringify({ id: call.id, ...answer }) + '\n');
  }
}
