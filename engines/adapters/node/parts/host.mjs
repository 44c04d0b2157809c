// The child's side of docs/reference/engine-protocol.md, for engines that run under node.
// An engine's file is started as: node ENGINE.mjs NODE_MODULES
import { createReadStream, writeSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { HERE, after, back, jointsOf, plus, read, rotated } from './building.mjs';

export const version = (name) => JSON.parse(read(`${name}/package.json`)).version;

const ALL = ['gravity', 'drag', 'torque_body', 'torque_world', 'pivot', 'table', 'rotors'];
export const method = (name, summary, more = {}) => ({ name, order: 1, attitude_order: 1, summary, effects: ALL, ...more });
const SINGLE = 2 ** -20;                         // some roundings of single precision
const isZero = (v) => v.every((x) => x === 0);
// What a joint is by the number of axes that it locks.
const KINDS = { 1: 'table', 3: 'pivot', 5: 'rotors', 6: 'rotors' };

// The joints as the engine holds them: that of a pivot or table, or null, then the rotors' hinges.
function jointsIn(held, scene, joint) {
  const described = jointsOf(scene), found = held.joints.map((one, k) => joint(one, described[k]));
  return scene.arm ? found : [null, ...found];
}

// The body and its rotors as the engine holds them, in the body's axes.
function composed(held, scene, body, joint) {
  const [first, ...rotors] = held.bodies.map(body), [base, ...hinges] = jointsIn(held, scene, joint);
  const q = held.motion(0).q;
  return { ...first, arm: base && base.here, parts: rotors.map((rotor, k) => {
    const { at, here, axis, locked } = hinges[k], turn = after(back(q), held.motion(k + 1).q);
    return { ...rotor, com: plus(at, rotated(turn, plus(rotor.com, here, -1))), frame: after(turn, rotor.frame), axis: locked === 6 ? HERE : axis };
  }) };
}

// Names of what acts: gravity and joints as the engine holds them, the scene's torques, which are
// applied from here and assumed to act, and `others`, descriptions of anything else.
function acting(held, scene, { gravity, others = {} }, joint) {
  const alike = gravity.every((x, i) => Math.abs(x - scene.gravity[i]) <= SINGLE * Math.hypot(...scene.gravity));
  const [base, ...hinges] = jointsIn(held, scene, joint), { rotors = [] } = scene;
  const found = { [alike ? 'gravity' : `a gravity of ${gravity} m/s²`]: !isZero(gravity), drag: scene.drag !== 0,
    torque_body: !isZero(scene.torque_body), torque_world: !isZero(scene.torque_world), ...others };
  for (const { locked } of [base, ...hinges].filter(Boolean)) found[KINDS[locked] ?? `a joint that locks ${locked} axes`] = true;
  rotors.forEach(({ hinge }, k) => {
    const { locked, driven } = hinges[k] ?? { locked: 0 };
    if (locked !== (hinge === 'locked' ? 6 : 5)) found[`rotor ${k + 1} on a ${hinge} hinge that locks ${locked} axes`] = true;
    if (driven !== (hinge === 'driven')) found[`rotor ${k + 1} ${driven ? 'with' : 'without'} a drive on a ${hinge} hinge`] = true;
  });
  return Object.keys(found).filter((name) => found[name]);
}

// Answers calls until the input ends. An engine's own functions are:
// open(scene, method, timestep): builds the scene, and returns `held`: bodies, joints, motion,
// state, advance and close, and what `acts` needs.
// body(one): mass, com, moments and frame of one of the bodies, in its own axes.
// joint(one, described): at, here, axis, locked, the number of locked axes, and driven, whether
// there is a drive; `described` is the joint's entry in `jointsOf`.
// acts(held): gravity, m/s², and others, whether anything else acts, by its description.
// All other arguments are the engine's description in the protocol, the answer to `hello`.
export async function serve({ open, body, joint, acts, ...engine }) {
  let held = null, opened = null, scene = null;
  // A restart builds a new world, which takes less time than to make an engine forget its steps.
  const build = (call) => { held?.close(); opened = call; scene = call.scene; held = open(scene, call.method, call.timestep); };
  const answers = {
    hello: () => ({ protocol: 1, restart: true, ...engine }),
    open: (call) => { build(call); return { body: composed(held, scene, body, joint), state: held.state() }; },
    restart: ({ id, do: _, timestep, ...motion }) => { build({ ...opened, timestep, scene: { ...scene, ...motion } }); return held.state(); },
    run: ({ steps }) => { held.advance(steps); return held.state(); },
    time: ({ steps }) => { const begun = performance.now(); held.advance(steps); return { seconds: (performance.now() - begun) / 1e3 }; },
    active: () => ({ active: acting(held, scene, acts(held), joint) }),
    close: () => { held?.close(); held = null; return {}; },
  };
  for await (const line of createInterface({ input: createReadStream(null, { fd: 0 }) })) {
    const call = JSON.parse(line);
    let answer;
    try { answer = answers[call.do](call); } catch (error) { answer = { error: String(error).slice(0, 500) }; }
    writeSync(+process.env.SPINCHECK_ANSWERS, JSON.stringify({ id: call.id, ...answer }) + '\n');
  }
}
