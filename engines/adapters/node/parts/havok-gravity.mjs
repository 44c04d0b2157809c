// The gravity that a body in Havok feels.
import { HERE, X, Y } from './building.mjs';

// Of the world's gravity Havok tells nothing: other bodies feel it, which move, for below 0.1 m/s it takes 3 % off.
// Along what a body moves by, its gain is rounded: each component is felt by one that moves across it.
export function gravityFelt(H, world, timestep) {
  const [alongX, alongY] = [X, Y].map((velocity) => {
    const probe = H.HP_Body_Create();
    H.HP_Body_SetMotionType(probe, H.MotionType.DYNAMIC);
    H.HP_Body_SetMassProperties(probe, [HERE, 1, [1, 1, 1], [0, 0, 0, 1]]);
    H.HP_Body_SetLinearDamping(probe, 0);
    H.HP_World_AddBody(world, probe, false);
    H.HP_Body_SetLinearVelocity(probe, velocity);
    return probe;
  });
  H.HP_World_Step(world, timestep);
  const [, y, z] = H.HP_Body_GetLinearVelocity(alongX), [x] = H.HP_Body_GetLinearVelocity(alongY);
  return [x, y, z].map((gain) => gain / timestep);
}
