// Rapier as WebAssembly, in single precision, its gyroscopic torque always on.
import { X, bodiesOf, jointsOf, load, rotated, stepped, vector, wxyz, xyz } from './parts/building.mjs';
import { method, serve } from './parts/host.mjs';

const R = await load('@dimforge/rapier3d-compat/dist/rapier.mjs');
const log = console.warn;
console.warn = () => {};                         // Rapier itself uses a deprecated option
await R.init();
console.warn = log;
const HINGE = 0b110111, FIRM = 1e9;               // all axes but rotation about x; gain of a drive

function open(scene, name, timestep) {
  const shipped = name === 'default';
  const world = new R.World(vector(scene.gravity));
  world.timestep = timestep;
  const bodies = bodiesOf(scene).map(({ mass, moments, q: [w, x, y, z], com, velocity, omega }) => {
    const about = R.RigidBodyDesc.dynamic().setTranslation(...com).setRotation({ x, y, z, w })
      .setLinvel(...velocity).setAngvel(vector(omega))
      .setAdditionalMassProperties(mass, vector([0, 0, 0]), vector(moments), { x: 0, y: 0, z: 0, w: 1 });
    if (!shipped) about.setCanSleep(false);
    const body = world.createRigidBody(about);
    body.recomputeMassPropertiesFromColliders(); // until then its mass reads 0
    return body;
  });
  const joints = jointsOf(scene).map(({ parent, child, at, turn, x, here, locked, spin }) => {
    const anchors = [vector(at), vector(here)], ends = [bodies[parent] ?? world.createRigidBody(R.RigidBodyDesc.fixed()), bodies[child]];
    const mask = locked.reduce((sum, lock, axis) => sum + lock * 2 ** axis, 0), [w, ...u] = turn;
    const about = mask === HINGE ? R.JointData.revoluteWithAxes(...anchors, vector(x), vector(X)) : R.JointData.generic(...anchors, vector(X), mask);
    const joint = world.createImpulseJoint(about, ...ends, true);
    if (mask !== HINGE) joint.setFrameX1({ ...vector(u), w });
    if (spin !== null) joint.configureMotorVelocity(spin, FIRM);
    return joint;
  });
  const motion = (k) => { const body = bodies[k];
    return { q: wxyz(body.rotation()), omega: xyz(body.angvel()), com: xyz(body.translation()), velocity: xyz(body.linvel()) }; };
  const apply = (torque) => { bodies[0].resetTorques(true); bodies[0].addTorque(vector(torque), true); };
  return { world, bodies, joints, ...stepped(scene, motion, apply, () => world.step()), close: () => world.free() };
}

// ANGULAR_MOTION_THRESHOLD of its sources, rad: a step turns a body no further.
const CLAMPS = { max_rotation_per_step: Math.PI / 4, clamps_parts: true };

serve({ name: 'rapier3d-js', version: R.version(), precision: 'single', stock_timestep: 1 / 60, open,
  body: (body) => ({ mass: body.mass(), com: xyz(body.localCom()), moments: xyz(body.principalInertia()), frame: wxyz(body.principalInertiaLocalFrame()) }),
  // Rapier reports neither the locked axes of a general joint nor drives: they are as described.
  joint: (joint, { locked, spin }) => ({ at: xyz(joint.anchor1()), here: xyz(joint.anchor2()), axis: rotated(wxyz(joint.frameX1()), X),
    locked: joint.type() === R.JointType.Revolute ? 5 : locked.filter(Boolean).length, driven: spin !== null }),
  acts: ({ world, bodies: [body, ...rotors] }) => ({ gravity: xyz(world.gravity).map((g) => g * body.gravityScale()), others: {
    damping: [body, ...rotors].some((one) => one.linearDamping() > 0 || one.angularDamping() > 0), sleeping: body.isSleeping(),
    'a collision shape': body.numColliders() > 0, 'a multibody joint': world.multibodyJoints.len() > 0 } }),
  methods: [method('impulse', 'semi-implicit Euler, the pivot as an impulse joint', CLAMPS),
    method('default', 'as shipped: may fall asleep', { ...CLAMPS, as_shipped: true })] });
