// Havok's calls with their result codes looked at, and a ball joint.
export const HERE = [0, 0, 0];
const X = [1, 0, 0], Y = [0, 1, 0];

// Each call of the module gives a code, [code, value] or [code, value, …]: here the value or values, or it throws.
export const checked = (module) => new Proxy(module, { get: (_, name) => {
  const call = module[name];
  if (!String(name).startsWith('HP_')) return call;
  return (...given) => {
    const [code, ...values] = [call(...given)].flat(1);
    if (code !== module.Result.RESULT_OK) throw new Error(`Havok says ${code.value ?? code}`);
    return values.length > 1 ? values : values[0];
  };
} });

export function jointAt(H, arm, world, body) {
  const ground = H.HP_Body_Create(), joint = H.HP_Constraint_Create();
  H.HP_Body_SetMotionType(ground, H.MotionType.STATIC);
  H.HP_World_AddBody(world, ground, false);
  H.HP_Constraint_SetParentBody(joint, ground);
  H.HP_Constraint_SetChildBody(joint, body);
  H.HP_Constraint_SetAnchorInParent(joint, HERE, X, Y);
  H.HP_Constraint_SetAnchorInChild(joint, arm, X, Y);
  for (const axis of ['LINEAR_X', 'LINEAR_Y', 'LINEAR_Z'])
    H.HP_Constraint_SetAxisMode(joint, H.ConstraintAxis[axis], H.ConstraintAxisLimitMode.LOCKED);
  H.HP_Constraint_SetCollisionsEnabled(joint, 0);
  H.HP_Constraint_SetEnabled(joint, 1);
  return joint;
}
