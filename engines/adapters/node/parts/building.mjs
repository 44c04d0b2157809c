// What a scene is built and stepped with, whatever the engine; the packages are in the folder of the argument.
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
// A quaternion w x y z: a vector turned by it, it after another, and back.
export const rotated = ([w, ...u], v) => { const c = cross(u, v).map((x) => 2 * x); return plus(plus(v, c, w), cross(u, c)); };
export const after = ([w, ...u], [s, ...v]) => [w * s - dot(u, v), ...plus(plus(cross(u, v), v, w), u, s)];
export const back = ([w, ...u]) => [w, ...u.map((x) => -x)];

export const X = [1, 0, 0], Y = [0, 1, 0], HERE = [0, 0, 0], UPRIGHT = [1, 0, 0, 0];
// The shortest rotation that takes x to a unit vector; about y where that is opposite to x.
function toAxis([x, y, z]) {
  const q = x > -0.5 ? [1 + x, 0, -z, y] : [-z, y, 1 - x, 0];
  return q.map((part) => part / Math.hypot(...q));
}

// The rigid bodies of a scene, each along its principal axes and from its com: the body, then its rotors, their axes along x.
export function bodiesOf({ mass, moments, q, com, velocity, omega, rotors = [], spins = [] }) {
  return [{ mass, moments, q, com, velocity, omega }, ...rotors.map(({ axis, place, mass, inertia: [across, along] }, k) => {
    const arm = rotated(q, place);
    return { mass, moments: [along, across, across], q: after(q, toAxis(axis)), com: plus(com, arm),
      velocity: plus(velocity, cross(omega, arm)), omega: plus(omega, rotated(q, axis), spins[k]) };
  })];
}

// Its joints, by the axes that each locks: of place along x, y, z of the parent's frame, then of rotation about them. Of a pivot
// or table, first, the parent is the world (-1) and a rotor's is the body (0); `at` and `turn` are of the joint's axes in the
// parent, `x` and `y` along them, `here` of its place in the child, along whose own axes they start; `spin` is of a drive.
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

// Reads the motion, from a body's place in `bodiesOf` to its q, omega, com, velocity; takes steps one by one, each after the
// scene's torques at the state then.
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
