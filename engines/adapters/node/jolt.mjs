// Jolt as WebAssembly, in single precision. It leaves out the gyroscopic torque unless asked for it.
import { X, Y, bodiesOf, jointsOf, load, stepped } from './parts/building.mjs';
import { method, serve, version } from './parts/host.mjs';

const J = await (await load('jolt-physics/dist/jolt-physics.wasm-compat.js'))();
const RADIUS = 0.05, FAST = 1e9;                 // m; m/s and rad/s, out of reach
const PLACES = ['X', 'Y', 'Z'], AXES = ['Translation', 'Rotation'].flatMap((kind) => PLACES.map((axis) => J[`SixDOFConstraintSettings_EAxis_${kind}${axis}`]));
const TWIST = J.SixDOFConstraintSettings_EAxis_RotationX;
const list = (v) => [v.GetX(), v.GetY(), v.GetZ()];
// What Jolt copies is listed until the world is built: JavaScript does not release what WebAssembly allocates.
const copies = [], make = (Kind, ...numbers) => { const made = new Kind(...numbers); copies.push(made); return made; };
const quaternion = (q) => [q.GetW(), q.GetX(), q.GetY(), q.GetZ()];

function world(gravity) {
  const settings = make(J.JoltSettings), layer = make(J.BroadPhaseLayer, 0);
  const pairs = new J.ObjectLayerPairFilterTable(1), layers = new J.BroadPhaseLayerInterfaceTable(1, 1);
  layers.MapObjectToBroadPhaseLayer(0, layer);
  const filter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 1, pairs, 1);
  Object.assign(settings, { mMaxWorkerThreads: 0, mObjectLayerPairFilter: pairs, mBroadPhaseLayerInterface: layers, mObjectVsBroadPhaseLayerFilter: filter });
  const jolt = new J.JoltInterface(settings);
  jolt.GetPhysicsSystem().SetGravity(make(J.Vec3, ...gravity));
  return jolt;
}

function open(scene, name, timestep) {
  const shipped = name === 'default', jolt = world(scene.gravity), system = jolt.GetPhysicsSystem(), ground = J.Body.prototype.sFixedToWorld;
  const owner = system.GetBodyInterface();
  const bodies = bodiesOf(scene).map(({ mass, moments, q: [w, x, y, z], com, velocity, omega }) => {
    const about = make(J.BodyCreationSettings, new J.SphereShape(RADIUS), make(J.RVec3, ...com), make(J.Quat, x, y, z, w), J.EMotionType_Dynamic, 0);
    about.mOverrideMassProperties = J.EOverrideMassProperties_MassAndInertiaProvided;
    about.mMassPropertiesOverride.mMass = mass;
    about.mMassPropertiesOverride.mInertia = J.Mat44.prototype.sScaleVec3(make(J.Vec3, ...moments));
    if (!shipped) Object.assign(about, { mLinearDamping: 0, mAngularDamping: 0, mAllowSleeping: false,
      mMaxAngularVelocity: FAST, mMaxLinearVelocity: FAST, mApplyGyroscopicForce: true });
    const body = owner.CreateBody(about);
    // For moments of some 1e-6 kg m² and less it would take those of a sphere of radius 1 m.
    if (!shipped) body.GetMotionProperties().SetInverseInertia(make(J.Vec3, ...moments.map((I) => 1 / I)), J.Quat.prototype.sIdentity());
    owner.AddBody(body.GetID(), J.EActivation_Activate);
    owner.SetLinearVelocity(body.GetID(), make(J.Vec3, ...velocity));
    owner.SetAngularVelocity(body.GetID(), make(J.Vec3, ...omega));
    return body;
  });
  const joints = jointsOf(scene).map(({ parent, child, at, x, y, here, locked, spin }) => {
    const about = Object.assign(make(J.SixDOFConstraintSettings), { mSpace: J.EConstraintSpace_LocalToBodyCOM,
      mPosition1: make(J.RVec3, ...at), mAxisX1: make(J.Vec3, ...x), mAxisY1: make(J.Vec3, ...y),
      mPosition2: make(J.RVec3, ...here), mAxisX2: make(J.Vec3, ...X), mAxisY2: make(J.Vec3, ...Y) });
    AXES.forEach((axis, k) => (locked[k] ? about.MakeFixedAxis(axis) : about.MakeFreeAxis(axis)));
    const joint = J.castObject(about.Create(bodies[parent] ?? ground, bodies[child]), J.SixDOFConstraint);
    if (spin !== null) {
      joint.SetMotorState(TWIST, J.EMotorState_Velocity);
      joint.SetTargetAngularVelocityCS(make(J.Vec3, spin, 0, 0));
    }
    system.AddConstraint(joint);
    return joint;
  });
  const motion = (k) => { const body = bodies[k]; return { q: quaternion(body.GetRotation()), omega: list(body.GetAngularVelocity()),
    com: list(body.GetCenterOfMassPosition()), velocity: list(body.GetLinearVelocity()) }; };
  const vec = new J.Vec3(), apply = (torque) => { vec.Set(...torque); bodies[0].AddTorque(vec); };
  copies.splice(0).forEach((one) => J.destroy(one));
  return { system, bodies, joints, ...stepped(scene, motion, apply, () => jolt.Step(timestep, 1)), close: () => [jolt, vec].forEach((one) => J.destroy(one)) };
}

serve({ name: 'jolt', version: version('jolt-physics'), precision: 'single', stock_timestep: 1 / 60, open,
  least_turn: 1e-6,                               // Body::AddRotationStep, and SubRotationStep for constraints
  body: (body) => { const motion = body.GetMotionProperties(); return { mass: 1 / motion.GetInverseMass(), com: [0, 0, 0],
    moments: list(motion.GetInverseInertiaDiagonal()).map((i) => 1 / i), frame: quaternion(motion.GetInertiaRotation()) }; },
  joint: (joint) => ({ at: list(joint.GetConstraintToBody1Matrix().GetTranslation()), here: list(joint.GetConstraintToBody2Matrix().GetTranslation()),
    axis: list(joint.GetConstraintToBody1Matrix().GetAxisX()), locked: AXES.filter((axis) => joint.IsFixedAxis(axis)).length,
    driven: joint.GetMotorState(TWIST) !== J.EMotorState_Off }),
  acts: ({ system, bodies }) => { const motions = bodies.map((body) => body.GetMotionProperties());
    return { gravity: list(system.GetGravity()).map((g) => g * motions[0].GetGravityFactor()), others: {
      damping: motions.some((one) => one.GetLinearDamping() > 0 || one.GetAngularDamping() > 0), sleeping: bodies[0].GetAllowSleeping(),
      'a velocity clamp': motions.some((one) => one.GetMaxAngularVelocity() < FAST), 'no gyroscopic torque': !bodies.every((one) => one.GetApplyGyroscopicForce()) } }; },
  methods: [method('gyroscopic', 'semi-implicit Euler, the gyroscopic torque switched on'),
    method('default', 'as shipped: without the gyroscopic torque, with damping and a velocity clamp', { as_shipped: true })] });
