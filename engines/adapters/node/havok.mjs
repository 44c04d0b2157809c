// Havok as WebAssembly (Babylon.js), in single precision. It has no gyroscopic torque and no switch for it.
import { acting, load, method, push, read, serve, version } from './host.mjs';

const wasmBinary = read('@babylonjs/havok/lib/esm/HavokPhysics.wasm');
const H = await (await load('@babylonjs/havok/lib/esm/HavokPhysics_es.js'))({ wasmBinary });
const RADIUS = 0.05, FAST = 1e6, HERE = [0, 0, 0], X = [1, 0, 0], Y = [0, 1, 0];
const got = (result) => {
  const [code, value] = Array.isArray(result) ? result : [result];
  if (code !== H.Result.RESULT_OK) throw new Error(`Havok says ${code?.value ?? code}`);
  return value;
};

function jointAt(arm, world, body) {
  const ground = got(H.HP_Body_Create()), joint = got(H.HP_Constraint_Create());
  got(H.HP_Body_SetMotionType(ground, H.MotionType.STATIC));
  got(H.HP_World_AddBody(world, ground, false));
  got(H.HP_Constraint_SetParentBody(joint, ground));
  got(H.HP_Constraint_SetChildBody(joint, body));
  got(H.HP_Constraint_SetAnchorInParent(joint, HERE, X, Y));
  got(H.HP_Constraint_SetAnchorInChild(joint, arm, X, Y));
  for (const axis of ['LINEAR_X', 'LINEAR_Y', 'LINEAR_Z'])
    got(H.HP_Constraint_SetAxisMode(joint, H.ConstraintAxis[axis], H.ConstraintAxisLimitMode.LOCKED));
  got(H.HP_Constraint_SetCollisionsEnabled(joint, 0));
  got(H.HP_Constraint_SetEnabled(joint, 1));
  return joint;
}

// Of the world's gravity Havok tells nothing: another body feels it, one that moves, for below 0.1 m/s it takes 3 % off.
function gravityFelt(world, timestep) {
  const probe = got(H.HP_Body_Create()), ALONG = [1, 0, 0], ROUNDED = 2 ** -22;
  got(H.HP_Body_SetMotionType(probe, H.MotionType.DYNAMIC));
  got(H.HP_Body_SetMassProperties(probe, [HERE, 1, [1, 1, 1], [0, 0, 0, 1]]));
  got(H.HP_Body_SetLinearDamping(probe, 0));
  got(H.HP_World_AddBody(world, probe, false));
  got(H.HP_Body_SetLinearVelocity(probe, ALONG));
  got(H.HP_World_Step(world, timestep));
  return got(H.HP_Body_GetLinearVelocity(probe)).map((v, i) => v - ALONG[i]).map((gain) => (Math.abs(gain) > ROUNDED ? gain / timestep : 0));
}

function open(scene, name, timestep) {
  const shipped = name === 'default', world = got(H.HP_World_Create()), body = got(H.HP_Body_Create());
  got(H.HP_World_SetGravity(world, scene.gravity));
  const [w, x, y, z] = scene.q;
  got(H.HP_Body_SetMotionType(body, H.MotionType.DYNAMIC));
  got(H.HP_Body_SetShape(body, got(H.HP_Shape_CreateSphere(HERE, RADIUS))));
  // Its moments are told a unit of mass.
  got(H.HP_Body_SetMassProperties(body, [HERE, scene.mass, scene.moments.map((I) => I / scene.mass), [0, 0, 0, 1]]));
  got(H.HP_Body_SetQTransform(body, [scene.com, [x, y, z, w]]));
  if (!shipped) {
    got(H.HP_World_SetIdealStepTime(world, timestep));
    got(H.HP_World_SetSpeedLimit(world, FAST, FAST));
    got(H.HP_Body_SetLinearDamping(body, 0));
    got(H.HP_Body_SetAngularDamping(body, 0));
    got(H.HP_Body_SetActivationControl(body, H.ActivationControl.ALWAYS_ACTIVE));
  }
  got(H.HP_World_AddBody(world, body, false));
  got(H.HP_Body_SetLinearVelocity(body, scene.velocity));
  got(H.HP_Body_SetAngularVelocity(body, scene.omega));
  const joint = scene.arm && jointAt(scene.arm, world, body), torque = push(scene);
  const state = () => { const [com, [x, y, z, w]] = got(H.HP_Body_GetQTransform(body));
    return { com, q: [w, x, y, z], omega: got(H.HP_Body_GetAngularVelocity(body)), velocity: got(H.HP_Body_GetLinearVelocity(body)) }; };
  return {
    body: () => { const [com, mass, moments, [x, y, z, w]] = got(H.HP_Body_GetMassProperties(body));
      return { mass, com, moments: moments.map((I) => I * mass), frame: [w, x, y, z], arm: joint && scene.arm }; },
    state,
    advance(steps) {
      for (let k = 0; k < steps; k++) {
        if (torque) { const { q, omega } = state(); got(H.HP_Body_ApplyAngularImpulse(body, torque(q, omega).map((t) => t * timestep))); }
        got(H.HP_World_Step(world, timestep));
      }
    },
    active: () => acting(scene, { gravity: gravityFelt(world, timestep), joints: joint && got(H.HP_Constraint_GetEnabled(joint)) ? 1 : 0, others: {
      damping: got(H.HP_Body_GetLinearDamping(body)) > 0 || got(H.HP_Body_GetAngularDamping(body)) > 0,
      'a velocity clamp': H.HP_World_GetSpeedLimit(world)[2] < FAST } }),
    close: () => H.HP_World_Release(world),
  };
}

serve({ name: 'havok', version: version('@babylonjs/havok'), precision: 'single', stock_timestep: 1 / 60, open,
  methods: [method('plain', 'semi-implicit Euler, damping and clamps off'),
    method('default', 'as shipped: with damping, a velocity clamp, sleeping', { as_shipped: true })] });
