// PhysX 5 as WebAssembly, in single precision. It leaves out the gyroscopic torque unless asked for it.
import { HERE, UPRIGHT, X, bodiesOf, jointsOf, load, read, rotated, stepped, wxyz, xyz } from './parts/building.mjs';
import { method, serve, version } from './parts/host.mjs';

// The module is not built for node, and refuses to start if it finds it. While it starts, `process`
// is hidden, and `window` and `document` stand in for those of a browser.
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
const pose = (place, [w, x, y, z]) => new P.PxTransform(vec(place), new P.PxQuat(x, y, z, w));
const AXES = ['eX', 'eY', 'eZ', 'eTWIST', 'eSWING1', 'eSWING2'].map((name) => P.PxD6AxisEnum[name]);
const { eTWIST } = P.PxD6DriveEnum, { eLOCKED, eFREE } = P.PxD6MotionEnum;

function open(told, name, timestep) {
  const shipped = name === 'default', about = new P.PxSceneDesc(scale);
  about.set_gravity(vec(told.gravity));
  about.set_cpuDispatcher(T.DefaultCpuDispatcherCreate(0));
  about.set_filterShader(T.DefaultFilterShader());
  if (name === 'tgs') about.set_solverType(P.PxSolverTypeEnum.eTGS);
  const scene = physics.createScene(about);
  const bodies = bodiesOf(told).map(({ mass, moments, q, com, velocity, omega }) => {
    const body = physics.createRigidDynamic(pose(com, q));
    body.setMass(mass), body.setMassSpaceInertiaTensor(vec(moments));
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
    body.setLinearVelocity(vec(velocity));
    body.setAngularVelocity(vec(omega));
    return body;
  });
  const joints = jointsOf(told).map(({ parent, child, at, turn, here, locked, spin }) => {
    const joint = T.D6JointCreate(physics, bodies[parent] ?? null, pose(at, turn), bodies[child], pose(here, UPRIGHT));
    AXES.forEach((axis, k) => joint.setMotion(axis, locked[k] ? eLOCKED : eFREE));
    if (spin !== null) {
      joint.setDrive(eTWIST, new P.PxD6JointDrive(0, FAST, FAST, true));
      joint.setDriveVelocity(vec(HERE), vec([-spin, 0, 0])); // of the parent relative to the child
    }
    return joint;
  });
  const motion = (k) => { const body = bodies[k], { q, p } = body.getGlobalPose();
    return { q: wxyz(q), com: xyz(p), omega: xyz(body.getAngularVelocity()), velocity: xyz(body.getLinearVelocity()) }; };
  const apply = (torque) => { const t = vec(torque); bodies[0].addTorque(t, P.PxForceModeEnum.eFORCE, true); P.destroy(t); };
  const step = () => { scene.simulate(timestep); scene.fetchResults(true); };
  return { scene, bodies, joints, ...stepped(told, motion, apply, step), close() { [...joints, ...bodies, scene].forEach((one) => one.release()); } };
}

serve({ name: 'physx', version: version('physx-js-webidl'), precision: 'single', stock_timestep: 1 / 60, open,
  body: (body) => { const at = body.getCMassLocalPose(); return { mass: body.getMass(), com: xyz(at.p), moments: xyz(body.getMassSpaceInertiaTensor()), frame: wxyz(at.q) }; },
  joint: (joint) => { const [[at, q], [here]] = ['eACTOR0', 'eACTOR1'].map((end) => { const { p, q } = joint.getLocalPose(P.PxJointActorIndexEnum[end]); return [xyz(p), wxyz(q)]; });
    return { at, here, axis: rotated(q, X), locked: AXES.filter((axis) => joint.getMotion(axis) === eLOCKED).length,
      driven: joint.getDrive(eTWIST).damping > 0 }; },
  acts: ({ scene, bodies }) => ({ gravity: xyz(scene.getGravity()), others: {
    damping: bodies.some((one) => one.getLinearDamping() > 0 || one.getAngularDamping() > 0), sleeping: bodies[0].getSleepThreshold() > 0,
    'a velocity clamp': bodies.some((one) => one.getMaxAngularVelocity() < FAST), 'no gyroscopic torque': !bodies.every((one) => one.getRigidBodyFlags().isSet(GYROSCOPIC)) } }),
  methods: [method('pgs', 'projected Gauss-Seidel, the gyroscopic torque switched on'),
    method('tgs', 'temporal Gauss-Seidel, the gyroscopic torque switched on'),
    method('default', 'as shipped: without the gyroscopic torque, with damping and a velocity clamp', { as_shipped: true })] });
