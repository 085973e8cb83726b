/** Step sizes, and the splitting of motions into steps. */

/** Maximum rotation of a joint in one step [rad]. */
const JOINT_STEP = 0.2;
/** Tolerance at which a joint counts as being at its target [rad]. */
export const THERE = 0.002;

export const DEGREE = Math.PI / 180;

/** Step sizes for people [degrees] and [mm]; the largest are the server's limits for one step. */
export const JOINT_SIZES = [1, 2, 5, 10] as const;
export const TURN_SIZES = [1, 5, 10, 20] as const;
export const TOOL_SIZES = [1, 5, 20, 100] as const;
export const BASE_SIZES = [10, 50, 100, 200] as const;

/** Returns the steps that bring all joints together to their targets, each within the limit. */
export function stepsTo(now: readonly number[], target: readonly number[]): number[][] {
  const ways = now.map((angle, joint) => (target[joint] ?? angle) - angle);
  const farthest = Math.max(0, ...ways.map(Math.abs));
  if (farthest <= THERE) return [];
  const many = Math.ceil(farthest / JOINT_STEP - 1e-9);
  return Array.from({ length: many }, () => ways.map((way) => way / many));
}

/** Returns (roll, pitch, yaw) [rad] of a unit quaternion (x, y, z, w): rotations about the fixed axes x, y, z. */
export function rollPitchYaw([x, y, z, w]: readonly [number, number, number, number]): [number, number, number] {
  const sine = Math.max(-1, Math.min(1, 2 * (w * y - z * x)));
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(sine),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}
