// cannon-es, in double precision. Its bodies turn without the gyroscopic torque ω × I ω.
import { load, stepped, xyz } from './parts/building.mjs';
import { method, serve, version } from './parts/host.mjs';

const C = await load('cannon-es/dist/cannon-es.cjs.js');
// For a joint that holds as rigidly as doubles allow; its own defaults suppose steps of 1/60 s.
const STIFFNESS = 1e12, RELAXATION = 3, ITERATIONS = 50;

function open(scene, name, timestep) {
  const shipped = name === 'default';
  const world = new C.World({ gravity: new C.Vec3(...scene.gravity) });
  const [w, x, y, z] = scene.q;
  const body = new C.Body({ mass: scene.mass, position: new C.Vec3(...scene.com), quaternion: new C.Quaternion(x, y, z, w),
    velocity: new C.Vec3(...scene.velocity), angularVelocity: new C.Vec3(...scene.omega) });
  if (!shipped) {
    body.linearDamping = body.angularDamping = 0;
    body.allowSleep = false;
    world.solver.iterations = ITERATIONS;
    world.solver.tolerance = 0;
  }
  world.addBody(body);
  body.invInertia.set(...scene.moments.map((moment) => 1 / moment));
  body.inertia.set(...scene.moments);
  body.updateInertiaWorld(true);
  let joint = null;
  if (scene.arm) {
    const ground = new C.Body({ mass: 0 });
    world.addBody(ground);
    joint = new C.PointToPointConstraint(body, new C.Vec3(...scene.arm), ground, new C.Vec3());
    if (!shipped) joint.equations.forEach((row) => row.setSpookParams(STIFFNESS, RELAXATION, timestep));
    world.addConstraint(joint);
  }
  const state = () => ({ q: [body.quaternion.w, ...xyz(body.quaternion)], omega: xyz(body.angularVelocity), com: xyz(body.position), velocity: xyz(body.velocity) });
  const advance = stepped(scene, state, (torque) => body.torque.set(...torque), () => world.step(timestep));
  return { world, body, joint, state, advance, close() {} };
}

serve({ name: 'cannon-es', version: version('cannon-es'), precision: 'double', stock_timestep: 1 / 60, open,
  body: ({ body, joint }) => ({ mass: 1 / body.invMass, com: [0, 0, 0], moments: xyz(body.invInertia).map((inverse) => 1 / inverse),
    frame: [1, 0, 0, 0], arm: joint && xyz(joint.pivotA) }),
  acts: ({ world, body }) => ({ gravity: xyz(world.gravity), joints: world.constraints.length, others: {
    damping: body.linearDamping > 0 || body.angularDamping > 0, sleeping: world.allowSleep,
    'a collision shape': world.bodies.some((one) => one.shapes.length > 0), contacts: world.contacts.length > 0 } }),
  methods: [method('point', 'symplectic Euler, a stiff point-to-point constraint'),
    method('default', 'as shipped: with damping, a softer constraint', { as_shipped: true, damping: 0.01 })] });
