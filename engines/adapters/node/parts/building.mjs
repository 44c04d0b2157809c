// Functions that build and step a scene in any engine. The folder of the npm packages is the first
// argument on the command line.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const path = (file) => join(process.argv[2] ?? 'node_modules', file);
export const read = (file) => readFileSync(path(file));
export const load = async (file) => { const found = await import(pathToFileURL(path(file))); return found.default ?? found; };

export const xyz = ({ x, y, z }) => [x, y, z];
export const vector = ([x, y, z]) => ({ x, y, z });
export const wxyz = ({ w, x, y, z }) => [w, x, y, z];

export const plus = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = ([x, y, z], v) => [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]];
// For quaternions w x y z: `rotated` turns a vector by one, `after` is the product, the turn by the
// first after that by the second, and `back` is the conjugate.
export const rotated = ([w, ...u], v) => { const c = cross(u, v).map((x) => 2 * x); return plus(plus(v, c, w), cross(u, c)); };
export const after = ([w, ...u], [s, ...v]) => [w * s - dot(u, v), ...plus(plus(cross(u, v), v, w), u, s)];
export const back = ([w, ...u]) => [w, ...u.map((x) => -x)];

export const X = [1, 0, 0], Y = [0, 1, 0], HERE = [0, 0, 0], UPRIGHT = [1, 0, 0, 0];
// The shortest rotation that takes x to a unit vector; about y where that is opposite to x.
function toAxis([x, y, z]) {
  const q = x > -0.5 ? [1 + x, 0, -z, y] : [-z, y, 1 - x, 0];
  return q.map((part) => part / Math.hypot(...q));
}

// The rigid bodies of a scene, as mass, moments and motion: the body, then its rotors. The axes of
// each are its principal axes, and its origin is its com; a rotor turns about its x axis.
export function bodiesOf({ mass, moments, q, com, velocity, omega, rotors = [], spins = [] }) {
  return [{ mass, moments, q, com, velocity, omega }, ...rotors.map(({ axis, place, mass, inertia: [across, along] }, k) => {
    const arm = rotated(q, place);
    return { mass, moments: [along, across, across], q: after(q, toAxis(axis)), com: plus(com, arm),
      velocity: plus(velocity, cross(omega, arm)), omega: plus(omega, rotated(q, axis), spins[k]) };
  })];
}

// The joints of a scene: first that of a pivot or table, if there is one, then the rotors' hinges.
// parent, child: indices in `bodiesOf`; the parent of a pivot or table is the world, -1.
// at, turn: place, m, and attitude, w x y z, of the joint's frame in the parent.
// x, y: the first two axes of that frame, unit vectors in the parent.
// here: place, m, of the joint's frame in the child; its axes there are the child's own.
// locked: for each axis, whether it is locked: translation along x, y and z of the joint's frame in
// the parent, then rotation about them.
// spin: the spin that a drive keeps, rad/s; null without a drive.
export function jointsOf({ arm, slides = [], height = 0, rotors = [], spins = [] }) {
  const joint = (parent, child, at, turn, here, locked, spin = null) =>
    ({ parent, child, at, turn, x: rotated(turn, X), y: rotated(turn, Y), here, locked, spin });
  const along = [0, 1, 2].map((axis) => !slides.includes(axis));
  return [...(arm ? [joint(-1, 0, [0, 0, height], UPRIGHT, arm, [...along, false, false, false])] : []),
    ...rotors.map(({ axis, place, hinge }, k) =>
      joint(0, k + 1, place, toAxis(axis), HERE, [true, true, true, hinge === 'locked', true, true], hinge === 'driven' ? spins[k] : null))];
}

// The scene's torques at an attitude and ω, world axes; null where it has none.
function push({ torque_world: t, torque_body: b, drag }) {
  if ([...t, ...b, drag].every((x) => x === 0)) return null;
  return (q, omega) => plus(plus(t, rotated(q, b)), omega, -drag);
}

// Returns functions of a scene that was built: `motion` as given; `state()`, which returns the
// motion of the body and the rotors' spins; and `advance(steps)`.
// motion(k): q, omega, com and velocity of the body with index k in `bodiesOf`.
// apply(torque): applies a torque, N m, world axes, to the body for the next step; called before
// each step, if the scene has torques, with those at the present state.
// step(): takes one step.
export function stepped(scene, motion, apply, step) {
  const torque = push(scene), { rotors = [] } = scene;
  const state = () => {
    const body = motion(0), spin = ({ axis }, k) => dot(rotated(body.q, axis), plus(motion(k + 1).omega, body.omega, -1));
    return { ...body, spins: rotors.map(spin) };
  };
  const advance = (steps) => {
    for (let k = 0; k < steps; k++) {
      if (torque) { const { q, omega } = motion(0); apply(torque(q, omega)); }
      step();
    }
  };
  return { motion, state, advance };
}
