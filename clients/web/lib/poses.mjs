// Poses: rigid 4 x 4 matrices of 16 numbers, column by column, as in three.js, glTF and WebGL.
import { OncollideError } from './module.mjs';

export const identity = Object.freeze([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** A pose from a position and a quaternion (x, y, z, w), which is normalised. */
export function pose(position, quaternion = [0, 0, 0, 1]) {
  const length = Math.hypot(...quaternion);
  if (!(length > 0 && Number.isFinite(length))) throw new OncollideError('usage', 'pose: the quaternion has no direction; give (x, y, z, w)');
  const [x, y, z, w] = Array.from(quaternion, (number) => number / length);
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0,
    2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0,
    2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0,
    position[0], position[1], position[2], 1,
  ];
}

/** Checks the form of poses, and returns them with their number. */
export function posesOf(given, call) {
  const numbers = given ?? identity;
  if (!(Array.isArray(numbers) || ArrayBuffer.isView(numbers)) || numbers.length % 16 || numbers.length === 0)
    throw new OncollideError('usage', `${call}: a pose has 16 numbers, column by column, and many poses lie one after the other; given: ${numbers?.length ?? typeof numbers}`);
  return { numbers, count: numbers.length / 16 };
}

/** The numbers of one pose, repeated. */
export function repeated(numbers, width, count) {
  if (numbers.length === width * count) return numbers;
  const made = new Float64Array(width * count);
  for (let i = 0; i < count; ++i) made.set(numbers, width * i);
  return made;
}
