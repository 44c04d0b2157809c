// Rapier as WebAssembly, in single precision, its gyroscopic torque always on.
import { load, stepped, vector, xyz } from './parts/building.mjs';
import { method, serve } from './parts/host.mjs';

const R = await load('@dimforge/rapier3d-compat/dist/rapier.mjs');
const log = console.warn;
console.warn = () => {};                         // of its own use of a deprecated option
await R.init();
console.warn = log;
const wxyz = ({ w, x, y, z }) => [w, x, y, z];

function open(scene, name, timestep) {
  const shipped = name === 'default';
  const world = new R.World(vector(scene.gravity));
  world.timestep = timestep;
  const [w, x, y, z] = scene.q;
  const about = R.RigidBodyDesc.dynamic().setTranslation(...scene.com).setRotation({ x, y, z, w })
    .setLinvel(...scene.velocity).setAngvel(vector(scene.omega))
    .setAdditionalMassProperties(scene.mass, vector([0, 0, 0]), vector(scene.moments), { x: 0, y: 0, z: 0, w: 1 });
  if (!shipped) about.setCanSleep(false);
  const body = world.createRigidBody(about);
  body.recomputeMassPropertiesFromColliders();   // until then its mass reads 0
  let joint = null;
  if (scene.arm) {
    const ground = world.createRigidBody(R.RigidBodyDesc.fixed());
    joint = world.createImpulseJoint(R.JointData.spherical(vector([0, 0, 0]), vector(scene.arm)), ground, body, true);
  }
  const state = () => ({ q: wxyz(body.rotation()), omega: xyz(body.angvel()), com: xyz(body.translation()), velocity: xyz(body.linvel()) });
  const apply = (torque) => { body.resetTorques(true); body.addTorque(vector(torque), true); };
  return { world, body, joint, state, advance: stepped(scene, state, apply, () => world.step()), close: () => world.free() };
}

// ANGULAR_MOTION_THRESHOLD of its sources, rad: a step turns a body no further.
const MOST_TURN = Math.PI / 4;

serve({ name: 'rapier3d-js', version: R.version(), precision: 'single', stock_timestep: 1 / 60, open,
  body: ({ body, joint }) => ({ mass: body.mass(), com: xyz(body.localCom()), moments: xyz(body.principalInertia()),
    frame: wxyz(body.principalInertiaLocalFrame()), arm: joint && xyz(joint.anchor2()) }),
  acts: ({ world, body }) => ({ gravity: xyz(world.gravity).map((g) => g * body.gravityScale()), joints: world.impulseJoints.len(), others: {
    damping: body.linearDamping() > 0 || body.angularDamping() > 0, sleeping: body.isSleeping(),
    'a collision shape': body.numColliders() > 0, 'a multibody joint': world.multibodyJoints.len() > 0 } }),
  methods: [method('impulse', 'semi-implicit Euler, the pivot as an impulse joint', { max_rotation_per_step: MOST_TURN }),
    method('default', 'as shipped: may fall asleep', { max_rotation_per_step: MOST_TURN, as_shipped: true })] });
