// Results of calls: columns of doubles in the module's memory, which become typed arrays, or an object for one row.
import { wasm } from './module.mjs';

const arrays = { f64: Float64Array, u8: Uint8Array, i32: Int32Array, vec3: Float64Array };

/** Columns of a schema, such as { bound: 'f64', point: 'vec3' }, copied out of the module. */
export function columns(schema, list = 0) {
  const module = wasm(), rows = module._oc_rows(list);
  let at = module._oc_results(list) >> 3;
  const made = {};
  for (const [name, type] of Object.entries(schema)) {
    const length = type === 'vec3' ? 3 * rows : rows;
    const numbers = module.HEAPF64.subarray(at, at + length);
    made[name] = type === 'bool' ? Uint8Array.from(numbers) : new arrays[type](numbers);
    at += length;
  }
  return made;
}

/** The only row, as an object of numbers and of arrays of three. */
export function row(schema, list = 0) {
  const module = wasm();
  const numbers = module.HEAPF64;
  let at = module._oc_results(list) >> 3;
  const made = {};
  for (const name in schema) {
    const type = schema[name];
    if (type === 'vec3') {
      made[name] = [numbers[at], numbers[at + 1], numbers[at + 2]];
      at += 3;
    } else {
      made[name] = type === 'bool' ? numbers[at] !== 0 : numbers[at];
      ++at;
    }
  }
  return made;
}

/** Row `i` of columns. */
export function rowOf(table, i) {
  const made = {};
  for (const name in table) made[name] = table[name][i];
  return made;
}

/** Column by column, rows as objects. */
export function rows(schema, list = 0) {
  const table = columns(schema, list), count = wasm()._oc_rows(list), made = [];
  for (let i = 0; i < count; ++i) {
    const one = {};
    for (const name in schema)
      one[name] = schema[name] === 'vec3' ? [...table[name].subarray(3 * i, 3 * i + 3)]
        : schema[name] === 'bool' ? table[name][i] !== 0 : table[name][i];
    made.push(one);
  }
  return made;
}

export const offsets = (list = 1) => Uint32Array.from(columns({ at: 'f64' }, list).at);
