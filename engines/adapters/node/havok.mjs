// Havok as WebAssembly (Babylon.js), in single precision. It has no gyroscopic torque and no switch for it.
import { load, read, stepped } from './parts/building.mjs';
import { HERE, checked, jointAt } from './parts/havok.mjs';
import { gravityFelt } from './parts/havok-gravity.mjs';
import { method, serve, version } from './parts/host.mjs';

const wasmBinary = read('@babylonjs/havok/lib/esm/HavokPhysics.wasm');
const H = checked(await (await load('@babylonjs/havok/lib/esm/HavokPhysics_es.js'))({ wasmBinary }));
const RADIUS = 0.05, FAST = 1e9;

function open(scene, name, timestep) {
  const shipped = name === 'default', world = H.HP_World_Create(), body = H.HP_Body_Create();
  H.HP_World_SetGravity(world, scene.gravity);
  const [w, x, y, z] = scene.q;
  H.HP_Body_SetMotionType(body, H.MotionType.DYNAMIC);
  H.HP_Body_SetShape(body, H.HP_Shape_CreateSphere(HERE, RADIUS));
  // Its moments are told a unit of mass.
  H.HP_Body_SetMassProperties(body, [HERE, scene.mass, scene.moments.map((I) => I / scene.mass), [0, 0, 0, 1]]);
  H.HP_Body_SetQTransform(body, [scene.com, [x, y, z, w]]);
  if (!shipped) {
    H.HP_World_SetIdealStepTime(world, timestep);
    H.HP_World_SetSpeedLimit(world, FAST, FAST);
    H.HP_Body_SetLinearDamping(body, 0);
    H.HP_Body_SetAngularDamping(body, 0);
    H.HP_Body_SetActivationControl(body, H.ActivationControl.ALWAYS_ACTIVE);
  }
  H.HP_World_AddBody(world, body, false);
  H.HP_Body_SetLinearVelocity(body, scene.velocity);
  H.HP_Body_SetAngularVelocity(body, scene.omega);
  const joint = scene.arm && jointAt(H, scene.arm, world, body);
  const state = () => { const [com, [x, y, z, w]] = H.HP_Body_GetQTransform(body);
    return { com, q: [w, x, y, z], omega: H.HP_Body_GetAngularVelocity(body), velocity: H.HP_Body_GetLinearVelocity(body) }; };
  const advance = stepped(scene, state, (torque) => H.HP_Body_ApplyAngularImpulse(body, torque.map((t) => t * timestep)),
    () => H.HP_World_Step(world, timestep));
  return { world, body, joint, timestep, state, advance, close: () => H.HP_World_Release(world) };
}

serve({ name: 'havok', version: version('@babylonjs/havok'), precision: 'single', stock_timestep: 1 / 60, open,
  body: ({ body, joint }, scene) => { const [com, mass, moments, [x, y, z, w]] = H.HP_Body_GetMassProperties(body);
    return { mass, com, moments: moments.map((I) => I * mass), frame: [w, x, y, z], arm: joint && scene.arm }; },
  acts: ({ world, body, joint, timestep }) => ({ gravity: gravityFelt(H, world, timestep), joints: joint && H.HP_Constraint_GetEnabled(joint) ? 1 : 0, others: {
    damping: H.HP_Body_GetLinearDamping(body) > 0 || H.HP_Body_GetAngularDamping(body) > 0,
    'a velocity clamp': H.HP_World_GetSpeedLimit(world)[1] < FAST } }),
  methods: [method('plain', 'semi-implicit Euler, damping and clamps off'),
    method('default', 'as shipped: with damping, a velocity clamp, sleeping', { as_shipped: true, damping: 0.1 })] });
