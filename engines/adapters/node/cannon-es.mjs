// cannon-es, in double precision. Its bodies turn without the gyroscopic torque ω × I ω.
import { bodiesOf, jointsOf, load, stepped, xyz } from './parts/building.mjs';
import { method, serve, version } from './parts/host.mjs';

const C = await load('cannon-es/dist/cannon-es.cjs.js');
// They make a joint as rigid as doubles allow; the defaults of cannon-es suppose steps of 1/60 s.
const STIFFNESS = 1e12, RELAXATION = 3, ITERATIONS = 50;

function open(scene, name, timestep) {
  const shipped = name === 'default';
  const world = new C.World({ gravity: new C.Vec3(...scene.gravity) });
  if (!shipped) {
    world.solver.iterations = ITERATIONS;
    world.solver.tolerance = 0;
  }
  const vec = (v) => new C.Vec3(...v);
  const bodies = bodiesOf(scene).map(({ mass, moments, q: [w, x, y, z], com, velocity, omega }) => {
    const body = new C.Body({ mass, position: vec(com), quaternion: new C.Quaternion(x, y, z, w), velocity: vec(velocity), angularVelocity: vec(omega) });
    if (!shipped) Object.assign(body, { linearDamping: 0, angularDamping: 0, allowSleep: false });
    world.addBody(body);
    body.invInertia.set(...moments.map((moment) => 1 / moment));
    body.inertia.set(...moments);
    body.updateInertiaWorld(true);
    return body;
  });
  const joints = jointsOf(scene).map(({ parent, child, at, x, here, locked, spin }) => {
    const first = bodies[parent] ?? new C.Body({ mass: 0 }), hinge = locked[4], fixed = hinge && locked[3];
    if (parent < 0) world.addBody(first);
    const joint = hinge ? new C.HingeConstraint(first, bodies[child], { pivotA: vec(at), pivotB: vec(here), axisA: vec(x) })
      : new C.PointToPointConstraint(first, vec(at), bodies[child], vec(here));
    joint.equations.slice(0, 3).forEach((row, axis) => { row.enabled = locked[axis]; });
    // A locked rotor is on a hinge whose motor keeps it at rest relative to the body.
    if (fixed || spin !== null) {
      joint.enableMotor();
      joint.setMotorSpeed(-(spin ?? 0));
      joint.setMotorMaxForce(Infinity);
    }
    if (!shipped) joint.equations.forEach((row) => row.setSpookParams(STIFFNESS, RELAXATION, timestep));
    world.addConstraint(joint);
    return joint;
  });
  const motion = (k) => { const { quaternion, angularVelocity, position, velocity } = bodies[k];
    return { q: [quaternion.w, ...xyz(quaternion)], omega: xyz(angularVelocity), com: xyz(position), velocity: xyz(velocity) }; };
  const apply = (torque) => bodies[0].torque.set(...torque);
  return { world, bodies, joints, ...stepped(scene, motion, apply, () => world.step(timestep)), close() {} };
}

serve({ name: 'cannon-es', version: version('cannon-es'), precision: 'double', stock_timestep: 1 / 60, open,
  body: (body) => ({ mass: 1 / body.invMass, com: [0, 0, 0], moments: xyz(body.invInertia).map((inverse) => 1 / inverse), frame: [1, 0, 0, 0] }),
  joint: (joint, { locked }) => { const driven = !locked[3] && (joint.motorEquation?.enabled ?? false);
    return { at: xyz(joint.pivotA), here: xyz(joint.pivotB), axis: joint.axisA && xyz(joint.axisA), driven,
      locked: joint.equations.filter((row) => row.enabled).length - driven }; },
  acts: ({ world, bodies }) => ({ gravity: xyz(world.gravity), others: {
    damping: bodies.some((one) => one.linearDamping > 0 || one.angularDamping > 0), sleeping: world.allowSleep,
    'a collision shape': world.bodies.some((one) => one.shapes.length > 0), contacts: world.contacts.length > 0 } }),
  methods: [method('point', 'symplectic Euler, a stiff point-to-point constraint'),
    method('default', 'as shipped: with damping, a softer constraint', { as_shipped: true })] });
