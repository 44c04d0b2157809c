// Measures the gravity that bodies in Havok feel.
import { HERE, X, Y } from './building.mjs';

// Returns the gravity, m/s². Havok does not report it, so two probes measure it by the velocity
// that they gain in a step. They move, because below 0.1 m/s a body feels gravity 3 % too weak.
// Each component is measured by a probe that moves across it, as the gain along the motion is rounded.
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
