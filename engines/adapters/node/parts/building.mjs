// What a scene is built and stepped with, whatever the engine; the packages are in the folder of the argument.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const path = (file) => join(process.argv[2] ?? 'node_modules', file);
export const read = (file) => readFileSync(path(file));
export const load = async (file) => { const found = await import(pathToFileURL(path(file))); return found.default ?? found; };

export const xyz = ({ x, y, z }) => [x, y, z];
export const vector = ([x, y, z]) => ({ x, y, z });

// The scene's torques at an attitude (w x y z) and ω, world axes; null where it has none.
function push({ torque_world: t, torque_body: b, drag }) {
  if ([...t, ...b, drag].every((x) => x === 0)) return null;
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
