// PhysX 5 as WebAssembly, in single precision. It leaves out the gyroscopic torque unless asked for it.
import { load, read, stepped, xyz } from './parts/building.mjs';
import { method, serve, version } from './parts/host.mjs';

// It is not built for node, looks for it and refuses: both stand in for a browser while it starts.
const node = globalThis.process, wasmBinary = read('physx-js-webidl/physx-js-webidl.wasm');
const starting = load('physx-js-webidl/physx-js-webidl.mjs');
Object.assign(globalThis, { process: undefined, window: globalThis, document: { currentScript: null } });
const P = await (await starting)({ wasmBinary });
Object.assign(globalThis, { process: node, window: undefined, document: undefined });
const GYROSCOPIC = 1 << 10;                      // PxRigidBodyFlag::eENABLE_GYROSCOPIC_FORCES, not in its enum
const FAST = 1e9;                                // rad/s, out of reach
const T = P.PxTopLevelFunctions.prototype, scale = new P.PxTolerancesScale();
const foundation = T.CreateFoundation(P.PHYSICS_VERSION, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback());
const physics = T.CreatePhysics(P.PHYSICS_VERSION, foundation, scale);
const vec = (v) => new P.PxVec3(...v);
const wxyz = ({ w, x, y, z }) => [w, x, y, z];

function open(told, name, timestep) {
  const shipped = name === 'default', about = new P.PxSceneDesc(scale);
  about.set_gravity(vec(told.gravity));
  about.set_cpuDispatcher(T.DefaultCpuDispatcherCreate(0));
  about.set_filterShader(T.DefaultFilterShader());
  if (name === 'tgs') about.set_solverType(P.PxSolverTypeEnum.eTGS);
  const scene = physics.createScene(about), [w, x, y, z] = told.q;
  const body = physics.createRigidDynamic(new P.PxTransform(vec(told.com), new P.PxQuat(x, y, z, w)));
  body.setMass(told.mass), body.setMassSpaceInertiaTensor(vec(told.moments));
  if (!shipped) {
    body.setLinearDamping(0);
    body.setAngularDamping(0);
    body.setMaxAngularVelocity(FAST);
    body.setSleepThreshold(0);
    const flags = body.getRigidBodyFlags();
    flags.raise(GYROSCOPIC);
    body.setRigidBodyFlags(flags);
  }
  scene.addActor(body);
  body.setLinearVelocity(vec(told.velocity));
  body.setAngularVelocity(vec(told.omega));
  const upright = new P.PxQuat(0, 0, 0, 1);
  const joint = told.arm && T.SphericalJointCreate(physics, null, new P.PxTransform(vec([0, 0, 0]), upright), body, new P.PxTransform(vec(told.arm), upright));
  const state = () => { const pose = body.getGlobalPose(); return { q: wxyz(pose.q), com: xyz(pose.p), omega: xyz(body.getAngularVelocity()), velocity: xyz(body.getLinearVelocity()) }; };
  const apply = (torque) => { const t = vec(torque); body.addTorque(t, P.PxForceModeEnum.eFORCE, true); P.destroy(t); };
  const step = () => { scene.simulate(timestep); scene.fetchResults(true); };
  return { scene, body, joint, state, advance: stepped(told, state, apply, step), close() { joint?.release(); body.release(); scene.release(); } };
}

serve({ name: 'physx', version: version('physx-js-webidl'), precision: 'single', stock_timestep: 1 / 60, open,
  body: ({ body, joint }) => { const at = body.getCMassLocalPose(), com = xyz(at.p), frame = wxyz(at.q);
    return { mass: body.getMass(), com, frame, moments: xyz(body.getMassSpaceInertiaTensor()), arm: joint && xyz(joint.getLocalPose(P.PxJointActorIndexEnum.eACTOR1).p) }; },
  acts: ({ scene, body, joint }) => ({ gravity: xyz(scene.getGravity()), joints: joint ? 1 : 0, others: {
    damping: body.getLinearDamping() > 0 || body.getAngularDamping() > 0, sleeping: body.getSleepThreshold() > 0,
    'a velocity clamp': body.getMaxAngularVelocity() < FAST, 'no gyroscopic torque': !body.getRigidBodyFlags().isSet(GYROSCOPIC) } }),
  methods: [method('pgs', 'projected Gauss-Seidel, the gyroscopic torque switched on'),
    method('tgs', 'temporal Gauss-Seidel, the gyroscopic torque switched on'),
    method('default', 'as shipped: without the gyroscopic torque, with damping and a velocity clamp', { as_shipped: true, damping: 0.05 })] });
