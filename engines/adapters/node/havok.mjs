// Havok as WebAssembly (Babylon.js), in single precision. It has no gyroscopic torque and no switch for it.
import { HERE, X, Y, bodiesOf, jointsOf, load, read, stepped } from './parts/building.mjs';
import { checked } from './parts/havok.mjs';
import { gravityFelt } from './parts/havok-gravity.mjs';
import { method, serve, version } from './parts/host.mjs';

const wasmBinary = read('@babylonjs/havok/lib/esm/HavokPhysics.wasm');
const H = checked(await (await load('@babylonjs/havok/lib/esm/HavokPhysics_es.js'))({ wasmBinary }));
const FAST = 1e9;
const AXES = ['LINEAR', 'ANGULAR'].flatMap((kind) => ['X', 'Y', 'Z'].map((axis) => H.ConstraintAxis[`${kind}_${axis}`])), TWIST = AXES[3];
const { LOCKED } = H.ConstraintAxisLimitMode, { VELOCITY } = H.ConstraintMotorType;

function open(scene, name, timestep) {
  const shipped = name === 'default', world = H.HP_World_Create();
  H.HP_World_SetGravity(world, scene.gravity);
  if (!shipped) {
    H.HP_World_SetIdealStepTime(world, timestep);
    H.HP_World_SetSpeedLimit(world, FAST, FAST);
  }
  const bodies = bodiesOf(scene).map(({ mass, moments, q: [w, x, y, z], com, velocity, omega }) => {
    const body = H.HP_Body_Create();
    H.HP_Body_SetMotionType(body, H.MotionType.DYNAMIC);
    // Havok takes moments per unit of mass.
    H.HP_Body_SetMassProperties(body, [HERE, mass, moments.map((I) => I / mass), [0, 0, 0, 1]]);
    H.HP_Body_SetQTransform(body, [com, [x, y, z, w]]);
    if (!shipped) {
      H.HP_Body_SetLinearDamping(body, 0);
      H.HP_Body_SetAngularDamping(body, 0);
      H.HP_Body_SetActivationControl(body, H.ActivationControl.ALWAYS_ACTIVE);
    }
    H.HP_World_AddBody(world, body, false);
    H.HP_Body_SetLinearVelocity(body, velocity);
    H.HP_Body_SetAngularVelocity(body, omega);
    return body;
  });
  const joints = jointsOf(scene).map(({ parent, child, at, x, y, here, locked, spin }) => {
    const joint = H.HP_Constraint_Create(), first = bodies[parent] ?? H.HP_Body_Create();
    if (parent < 0) { H.HP_Body_SetMotionType(first, H.MotionType.STATIC); H.HP_World_AddBody(world, first, false); }
    H.HP_Constraint_SetParentBody(joint, first);
    H.HP_Constraint_SetChildBody(joint, bodies[child]);
    H.HP_Constraint_SetAnchorInParent(joint, at, x, y);
    H.HP_Constraint_SetAnchorInChild(joint, here, X, Y);
    AXES.forEach((axis, k) => locked[k] && H.HP_Constraint_SetAxisMode(joint, axis, LOCKED));
    if (spin !== null) {
      H.HP_Constraint_SetAxisMotorType(joint, TWIST, VELOCITY);
      H.HP_Constraint_SetAxisMotorVelocityTarget(joint, TWIST, spin);
      H.HP_Constraint_SetAxisMotorMaxForce(joint, TWIST, FAST);
    }
    H.HP_Constraint_SetCollisionsEnabled(joint, 0);
    H.HP_Constraint_SetEnabled(joint, 1);
    return joint;
  });
  const motion = (k) => { const body = bodies[k], [com, [x, y, z, w]] = H.HP_Body_GetQTransform(body);
    return { com, q: [w, x, y, z], omega: H.HP_Body_GetAngularVelocity(body), velocity: H.HP_Body_GetLinearVelocity(body) }; };
  const apply = (torque) => H.HP_Body_ApplyAngularImpulse(bodies[0], torque.map((t) => t * timestep));
  return { world, bodies, joints, timestep, ...stepped(scene, motion, apply, () => H.HP_World_Step(world, timestep)), close: () => H.HP_World_Release(world) };
}

serve({ name: 'havok', version: version('@babylonjs/havok'), precision: 'single', stock_timestep: 1 / 60, open,
  body: (body) => { const [com, mass, moments, [x, y, z, w]] = H.HP_Body_GetMassProperties(body);
    return { mass, com, moments: moments.map((I) => I * mass), frame: [w, x, y, z] }; },
  // Havok does not report a joint's places and axis: they are as described.
  joint: (joint, { at, here, x }) => ({ at, here, axis: x, driven: H.HP_Constraint_GetAxisMotorType(joint, TWIST) === VELOCITY,
    locked: H.HP_Constraint_GetEnabled(joint) ? AXES.filter((axis) => H.HP_Constraint_GetAxisMode(joint, axis) === LOCKED).length : 0 }),
  acts: ({ world, bodies, timestep }) => ({ gravity: gravityFelt(H, world, timestep), others: {
    damping: bodies.some((one) => H.HP_Body_GetLinearDamping(one) > 0 || H.HP_Body_GetAngularDamping(one) > 0),
    'a velocity clamp': H.HP_World_GetSpeedLimit(world)[1] < FAST } }),
  methods: [method('plain', 'semi-implicit Euler, damping and clamps off'),
    method('default', 'as shipped: with damping, a velocity clamp, sleeping', { as_shipped: true })] });
