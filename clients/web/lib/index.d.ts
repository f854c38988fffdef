import type { Contacts, Decision, Distance, DistanceOptions, FrameManifolds, ManifoldOptions, Pairs, Penetration, Space } from './queries.js';
export * from './queries.js';

/**
 * Loads the WebAssembly module, once; every other call needs it. The module has two parts. `ready` waits for the first, which
 * has verdicts, distances, contacts, casts and steps of meshes and shapes, and then loads the rest in the background. A call that
 * needs the rest earlier waits for it; await whole() first where this must not be: hulls, terrains, maps, manifolds, sweeps and
 * files need it. Throws no_input if the first part cannot be loaded.
 */
export function ready(options?: {
  /** Where oncollide.wasm is, or its bytes, or the compiled module; by default beside this package. */
  wasm?: Place;
  /** The same of oncollide-rest.wasm; by default beside oncollide.wasm if that has a place, else beside this package. */
  rest?: Place;
}): Promise<void>;
/**
 * Waits for both parts. Throws no_input if one cannot be loaded. Without the rest, a call that would create a hull, a terrain, a map
 * or a geometry from a file throws no_input, too; any other call that needs it does so half-way, and then all calls do.
 */
export function whole(): Promise<void>;
export type Place = string | URL | ArrayBuffer | ArrayBufferView | WebAssembly.Module;

/** The only error that calls throw. A call that throws has changed nothing. */
export class OncollideError extends Error {
  /**
   * usage: a call that makes no sense; bad_data: content that is invalid; no_input: something is missing; internal: a fault of
   * oncollide, or no memory.
   */
  readonly kind: 'usage' | 'bad_data' | 'no_input' | 'internal' | 'no_gpu' | 'cannot_write';
  /** The end of the message that names the cure; may be empty. */
  get cure(): string;
}

export type Vec3 = [number, number, number];
/** Numbers: a typed array, or an array. */
export type Numbers = ArrayLike<number> & Iterable<number>;
/** A rigid 4 x 4 matrix as 16 numbers, column by column, as three.js and glTF have them; many lie one after the other. Metres. */
export type Pose = Numbers;

/** A pose from a position and a quaternion (x, y, z, w), which need not have length 1. */
export function pose(position: Numbers, quaternion?: Numbers): number[];

export const Verdict: Readonly<{
  /** The distance is above the clearance, and at least the bound. */
  separate: 0;
  /** The distance is at most the bound; the bodies may or may not collide. */
  within: 1;
  /** The surfaces meet, or one solid encloses a part of the other. */
  colliding: 2;
  /** A limit stopped the test; the distance is at most the bound. */
  undecided: 3;
}>;
export const ContactKind: Readonly<{ unknown: 0; near: 1; touching: 2; crossing: 3; enclosed: 4 }>;
export const Stage: Readonly<{ bounds: 0; delimitation: 1; broad: 2; refine: 3; exact: 4 }>;
export const RegionKind: Readonly<{ crossing: 0; touching: 1; enclosed: 2; near: 3 }>;

// --- Geometries.

/** A mesh, a shape, a terrain or a map in its own frame, metres. Worlds share it: it may be disposed of once it is added. */
export class Geometry {
  private constructor();
  readonly name: string;
  readonly kind: 'mesh' | 'map' | 'terrain' | 'sphere' | 'box' | 'capsule' | 'cylinder' | 'hull' | 'ellipsoid' | 'cone' | 'half_space';
  readonly bounds: { min: Vec3; max: Vec3 };
  readonly vertexCount: number;
  readonly faceCount: number;
  /** A copy of a mesh's vertices, three numbers each. */
  readonly vertices: Float64Array;
  /** A copy of a mesh's triangles, three vertices each. */
  readonly faces: Uint32Array;
  /** Whether a mesh has an inside. Cost: O(n log n). */
  readonly closed: boolean;
  /** Frees it; a geometry that is forgotten is freed some time later. */
  dispose(): void;
}
export interface Named {
  /** For messages. */
  name?: string;
}
/**
 * A mesh. Without `faces`, each three vertices are a triangle.
 * Throws bad_data for an index out of range, a vertex that is not finite or beyond 1e15 m, and no triangle.
 */
export function mesh(vertices: Numbers, faces?: Numbers | null, options?: Named): Geometry;
// Solid shapes around their own origin; capsules, cylinders and cones along z.
export function sphere(radius: number, options?: Named): Geometry;
export function box(halfExtents: Numbers, options?: Named): Geometry;
/** `length` without the caps. */
export function capsule(radius: number, length: number, options?: Named): Geometry;
export function cylinder(radius: number, length: number, options?: Named): Geometry;
export function ellipsoid(semiAxes: Numbers, options?: Named): Geometry;
export function cone(radius: number, length: number, options?: Named): Geometry;
/** The hull of points that are not in a plane. */
export function convexHull(points: Numbers, options?: Named): Geometry;
/** All points with z <= 0. */
export function halfSpace(options?: Named): Geometry;
/** A surface over a grid of heights, row by row; NaN is a hole. `error` bounds the error of the heights. */
export function terrain(heights: Numbers, columns: number, options?: Named & { spacing?: number | [number, number]; origin?: Numbers; error?: number }): Geometry;
/** Occupied cells, three whole numbers each: cell i is from i to i + 1 resolutions. */
export function occupancyMap(cells: Numbers, resolution: number, options?: Named): Geometry;
/**
 * Reads a file: STL, OBJ, PLY, OFF, glTF, GLB, and terrains as PGM and NPY.
 * @param name its extension selects the reader
 * @param options.files other files that it refers to, such as the .bin of a .gltf, by their relative names
 * Throws bad_data with the line or place of the first fault.
 */
export function load(name: string, bytes: Uint8Array | ArrayBuffer | string, options?: {
  files?: Record<string, Uint8Array | ArrayBuffer | string>;
  /** Metres per unit. */
  scale?: number;
  /** Scale to this diagonal of the bounding box. */
  fitDiagonal?: number;
  /** Move the bounding box's centre to the origin. */
  centre?: boolean;
}): Geometry;
// Closed meshes for tests, equal on every machine.
export function boxMesh(halfExtents: Numbers, options?: Named): Geometry;
export function sphereMesh(radius: number, triangles: number, options?: Named): Geometry;
export function torusMesh(major: number, minor: number, triangles: number, options?: Named): Geometry;
export function torusKnotMesh(p: number, q: number, major: number, minor: number, tube: number, triangles: number, options?: Named): Geometry;

// --- Worlds.

/** How a World decides pairs; the table in docs/choosing.md describes each setting. The defaults suit most scenes: exact. */
export interface Settings {
  /** Metres: two bodies reported `within` are closer than clearance + maxError. */
  maxError?: number | null;
  /** 1 to 16: the depth of all sphere-trees. */
  depth?: number | null;
  /** Metres: pairs this close count as touching. */
  clearance?: number;
  exact?: 'auto' | 'on' | 'off' | 'predicates';
  contactKinds?: boolean;
  ignoreTouching?: boolean;
  mode?: 'surface' | 'solid';
  openAsSurface?: boolean;
  boundingVolume?: 'auto' | 'sphere' | 'obb';
  broadPhase?: 'kd' | 'octree' | 'brute';
  skip?: string[];
  ageLimit?: number;
  nodeBudget?: number;
  memoryBudget?: number;
  coherence?: boolean;
  [other: string]: unknown;
}

/**
 * Bodies and their models; finds which of them collide, from step to step at the cost of what changed.
 *
 *     await ready();
 *     const world = new World();
 *     const model = world.models.add(sphereMesh(1, 5000));
 *     const [a, b] = [0, 1.9].map((x) => world.bodies.add(model, pose([x, 0, 0])));
 *     for (const verdict of world.step().met.verdict) console.log(verdict === Verdict.colliding);
 *     world.dispose();
 */
export class World {
  /** Throws usage for an unknown setting or a value out of range. */
  constructor(settings?: Settings);
  readonly models: Models;
  readonly bodies: Bodies;
  readonly pairs: Pairs;
  readonly space: Space;
  /** All settings, with defaults. */
  readonly settings: Settings;
  /** Hash of all steps so far: equal input gives an equal hash on every system. */
  readonly hash: bigint;
  /** Reports all pairs as the bodies are now. */
  step(): Frame;
  /** Counts, and the bytes of trees. */
  inspect(): { bodies: number; models: number; frames: number; bytes: number };
  /** Frees the World; a World that is forgotten is freed some time later. */
  dispose(): void;
}

/** Pairs as columns: entry i of each belongs to pair i. */
export interface PairColumns {
  /** Bodies. */
  a: Float64Array;
  b: Float64Array;
  /** Values of Verdict. */
  verdict: Uint8Array;
  /** Values of ContactKind. */
  kind: Uint8Array;
  /** Values of Stage: the one that decided. */
  stage: Uint8Array;
  /** Metres. separate: lower bound on the distance; within, undecided: upper bound; colliding: 0. */
  bound: Float64Array;
}
/** The results of a step. Read its lists before the next step; each is copied once, when it is first read. */
export interface Frame {
  readonly frame: number;
  readonly ms: number;
  /** Of the pairs that are not separate. */
  readonly hash: bigint;
  readonly pairCount: number;
  readonly beganCount: number;
  readonly endedCount: number;
  /** Every pair that the broad phase kept, separate ones included. */
  readonly pairs: PairColumns;
  /** The pairs that are not separate. */
  readonly met: PairColumns;
  /** Pairs that are not separate now, and were before. */
  readonly began: { a: Float64Array; b: Float64Array };
  readonly ended: { a: Float64Array; b: Float64Array };
  /**
   * The contacts of this step for a solver, as Pairs.manifold() reduces them: of its pairs that meet or are at most the margin apart.
   * With a margin, set Settings.clearance to at least as much. Read before the next step, and before bodies or models change.
   * Cost: pairs whose bodies did not change since the step before are copied.
   */
  manifolds(options?: ManifoldOptions): FrameManifolds;
  /** Pairs of boxes and of triangles that this step tested; nodes of all trees, and their bytes. */
  readonly trees: { nodePairs: number; trianglePairs: number; nodes: number; bytes: number };
}

/** The models of a World: geometries that bodies share. A model is a number. */
export interface Models {
  readonly size: number;
  add(geometry: Geometry): number;
  replace(model: number, geometry: Geometry): void;
  /** Throws usage while a body uses it. */
  remove(model: number): void;
  has(model: number): boolean;
  /** Gives the vertices of a mesh new positions, from vertex `first` on. */
  setVertices(model: number, positions: Numbers, first?: number | null): void;
  closed(model: number): boolean;
  /** Pairs of triangles of a mesh that meet beyond their shared vertices and edges; at most `most`. */
  selfContacts(model: number, most?: number): { a: Uint32Array; b: Uint32Array };
  bounds(model: number, pose?: Pose): { min: Vec3; max: Vec3 };
  /** The spheres at which the model's sphere-tree ends now, in its frame, to draw them: it grows where tests reach. */
  spheres(model: number): { center: Float64Array; radius: Float64Array; level: Uint8Array };
}

export interface Filter {
  /** Bits: the layers that the body is on. */
  layer?: number;
  /** Bits: the layers that it collides with. */
  mask?: number;
  /** Bodies of one group other than 0 form no pairs. */
  group?: number;
}
export interface BodyOptions extends Filter {
  /** Two static bodies never form a pair. */
  isStatic?: boolean;
  /** Yours; a whole number. */
  user?: number;
}
/** One body, or many. */
export type BodyList = number | Numbers;
/** The bodies of a World. A body is a number, exact; one that was removed, or is of another World, is refused. */
export interface Bodies {
  readonly size: number;
  /** One body; with many poses, one for each, as a Float64Array. */
  add(model: number, pose?: Pose | null, options?: BodyOptions): any;
  remove(bodies: BodyList): void;
  has(body: number): boolean;
  /** 16 numbers for each body. */
  pose(bodies: BodyList): Float64Array;
  /** Throws bad_data for a pose that is not rigid. */
  setPose(bodies: BodyList, poses: Pose): void;
  /** Moves bodies as setPose() does; the next step reports contacts on the way. */
  setMotion(bodies: BodyList, poses: Pose, options?: { path?: 'linear' | 'screw' }): void;
  setStatic(bodies: BodyList, isStatic: boolean): void;
  sleep(bodies: BodyList): void;
  wake(bodies: BodyList): void;
  setFilter(bodies: BodyList, filter: Filter): void;
  setModel(bodies: BodyList, model: number): void;
  /** The two never form a pair, until include(). */
  exclude(a: number, b: number): void;
  include(a: number, b: number): void;
  info(body: number): { model: number; isStatic: boolean; isAsleep: boolean; layer: number; mask: number; group: number; user: number };
}

// --- Two geometries at two poses (null: the identity), in one line; a World keeps what these work out each time.
export function collide(a: Geometry, poseA: Pose | null, b: Geometry, poseB: Pose | null): Decision;
export function distance(a: Geometry, poseA: Pose | null, b: Geometry, poseB: Pose | null, options?: DistanceOptions): Distance;
export function contacts(a: Geometry, poseA: Pose | null, b: Geometry, poseB: Pose | null): Contacts;
export function penetration(a: Geometry, poseA: Pose | null, b: Geometry, poseB: Pose | null): Penetration;
