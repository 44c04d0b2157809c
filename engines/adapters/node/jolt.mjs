// Jolt as WebAssembly, in single precision. It leaves out the gyroscopic torque unless asked for it.
import { load, stepped } from './parts/building.mjs';
import { method, serve, version } from './parts/host.mjs';

const J = await (await load('jolt-physics/dist/jolt-physics.wasm-compat.js'))();
const RADIUS = 0.05, FAST = 1e9;                 // m; m/s and rad/s, out of reach
const list = (v) => [v.GetX(), v.GetY(), v.GetZ()];
const wxyz = (q) => [q.GetW(), q.GetX(), q.GetY(), q.GetZ()];

function world(gravity) {
  const settings = new J.JoltSettings(), layer = new J.BroadPhaseLayer(0);
  const pairs = new J.ObjectLayerPairFilterTable(1), layers = new J.BroadPhaseLayerInterfaceTable(1, 1);
  layers.MapObjectToBroadPhaseLayer(0, layer);
  const filter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 1, pairs, 1);
  Object.assign(settings, { mMaxWorkerThreads: 0, mObjectLayerPairFilter: pairs, mBroadPhaseLayerInterface: layers, mObjectVsBroadPhaseLayerFilter: filter });
  const jolt = new J.JoltInterface(settings);
  jolt.GetPhysicsSystem().SetGravity(new J.Vec3(...gravity));
  return jolt;
}

function open(scene, name, timestep) {
  const shipped = name === 'default', jolt = world(scene.gravity), system = jolt.GetPhysicsSystem();
  const [w, x, y, z] = scene.q;
  const about = new J.BodyCreationSettings(new J.SphereShape(RADIUS), new J.RVec3(...scene.com), new J.Quat(x, y, z, w), J.EMotionType_Dynamic, 0);
  about.mOverrideMassProperties = J.EOverrideMassProperties_MassAndInertiaProvided;
  about.mMassPropertiesOverride.mMass = scene.mass;
  about.mMassPropertiesOverride.mInertia = J.Mat44.prototype.sScaleVec3(new J.Vec3(...scene.moments));
  if (!shipped) Object.assign(about, { mLinearDamping: 0, mAngularDamping: 0, mAllowSleeping: false,
    mMaxAngularVelocity: FAST, mMaxLinearVelocity: FAST, mApplyGyroscopicForce: true });
  const bodies = system.GetBodyInterface(), body = bodies.CreateBody(about), motion = body.GetMotionProperties();
  // For moments of some 1e-6 kg m² and less it would take those of a sphere of radius 1 m.
  if (!shipped) motion.SetInverseInertia(new J.Vec3(...scene.moments.map((I) => 1 / I)), J.Quat.prototype.sIdentity());
  bodies.AddBody(body.GetID(), J.EActivation_Activate);
  let arm = null;
  if (scene.arm) {
    const joint = Object.assign(new J.PointConstraintSettings(), { mSpace: J.EConstraintSpace_LocalToBodyCOM, mPoint2: new J.RVec3(...scene.arm) });
    const held = J.castObject(joint.Create(J.Body.prototype.sFixedToWorld, body), J.PointConstraint);
    system.AddConstraint(held);
    arm = list(held.GetLocalSpacePoint2());
  }
  bodies.SetLinearVelocity(body.GetID(), new J.Vec3(...scene.velocity));
  bodies.SetAngularVelocity(body.GetID(), new J.Vec3(...scene.omega));
  const vec = new J.Vec3(), apply = (torque) => { vec.Set(...torque); body.AddTorque(vec); };
  const state = () => ({ q: wxyz(body.GetRotation()), omega: list(body.GetAngularVelocity()),
    com: list(body.GetCenterOfMassPosition()), velocity: list(body.GetLinearVelocity()) });
  const advance = stepped(scene, state, apply, () => jolt.Step(timestep, 1));
  return { system, body, motion, arm, state, advance, close: () => J.destroy(jolt) };
}

serve({ name: 'jolt', version: version('jolt-physics'), precision: 'single', stock_timestep: 1 / 60, open,
  body: ({ motion, arm }) => ({ mass: 1 / motion.GetInverseMass(), com: [0, 0, 0],
    moments: list(motion.GetInverseInertiaDiagonal()).map((i) => 1 / i), frame: wxyz(motion.GetInertiaRotation()), arm }),
  acts: ({ system, body, motion, arm }) => ({ gravity: list(system.GetGravity()).map((g) => g * motion.GetGravityFactor()), joints: arm ? 1 : 0, others: {
    damping: motion.GetLinearDamping() > 0 || motion.GetAngularDamping() > 0, sleeping: body.GetAllowSleeping(),
    'a velocity clamp': motion.GetMaxAngularVelocity() < FAST, 'no gyroscopic torque': !body.GetApplyGyroscopicForce() } }),
  methods: [method('gyroscopic', 'semi-implicit Euler, the gyroscopic torque switched on'),
    method('default', 'as shipped: without the gyroscopic torque, with damping and a velocity clamp', { as_shipped: true, damping: 0.05 })] });
