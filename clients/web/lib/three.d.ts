import type { BufferGeometry, InstancedMesh, Mesh, Ray, Raycaster } from 'three';
import type { BodyOptions, Contacts, Decision, Distance, DistanceOptions, Geometry, ManifoldOptions, Penetration, Region, Settings, Vec3, World } from './index.js';

/**
 * The triangles of a BufferGeometry as a geometry of oncollide.
 * @param scale multiplies the positions; a mirror keeps the inside inside
 */
export function geometryOf(buffer: BufferGeometry, scale?: Vec3, name?: string): Geometry;

/** An object of three.js, or one instance of an InstancedMesh. */
export type ThreeSide = Mesh | InstancedMesh | [InstancedMesh, number];

/** Where a body comes from. */
export interface ThreePlace {
  object: Mesh | InstancedMesh;
  /** Of an InstancedMesh; null for a Mesh. */
  instance: number | null;
}

/** A pair of a step that is not separate. */
export interface ThreePair {
  a: ThreePlace;
  b: ThreePlace;
  /** A value of Verdict. */
  verdict: number;
  /** A value of ContactKind. */
  kind: number;
  /** Certified, in units of the scene. */
  bound: number;
}

/** A point of contact. */
export interface ThreePoint {
  pointA: Vec3;
  pointB: Vec3;
  /** From a to b. */
  normal: Vec3;
  /** Negative: apart. */
  depth: number;
  depthError: number;
}

/** The contacts of a pair of a step. */
export interface ThreeManifold {
  a: ThreePlace;
  b: ThreePlace;
  /** Each with its points. */
  regions: (Omit<Region, 'first' | 'count'> & { points: ThreePoint[] })[];
  /** Whether no limit left out a region or a point. */
  complete: boolean;
}

/** A hit of a ray. */
export interface ThreeHit extends ThreePlace {
  body: number;
  verdict: number;
  point: Vec3;
  normal: Vec3;
  /** From the ray's origin; a certified lower bound. */
  distance: number;
  faceIndex: number;
}

/**
 * A World whose bodies are meshes and instances of three.js. Objects with one BufferGeometry and one scale share a model.
 * Positions are read when an object is added; matrices whenever update(), step() or a query of two objects runs.
 *
 *     const world = new ThreeWorld();
 *     world.add(bunny); world.add(ground, { isStatic: true });
 *     for (const { a, b } of world.step()) a.object.material.color.set('red');
 */
export class ThreeWorld {
  /** Throws as World. */
  constructor(settings?: Settings);
  /** The World itself, for everything else. */
  readonly world: World;
  /** Returns the body, or the bodies of all instances. Throws OncollideError for a sheared matrix. */
  add(object: Mesh, options?: BodyOptions): number;
  add(object: InstancedMesh, options?: BodyOptions): Float64Array;
  remove(object: Mesh | InstancedMesh): void;
  bodyOf(object: Mesh | InstancedMesh, instance?: number): number;
  objectOf(body: number): ThreePlace | null;
  /** Moves the bodies of these objects, by default of all, to where the objects are. */
  update(objects?: Iterable<Mesh | InstancedMesh>): void;
  /** Call it after the positions of the object's geometry have changed. */
  updateGeometry(object: Mesh | InstancedMesh): void;
  /** update() of all, World.step(), and its pairs that are not separate. */
  step(): ThreePair[];
  /** The contacts of the last step, as Frame.manifolds() finds them. Throws usage if objects were moved by update() since. */
  manifolds(options?: ManifoldOptions): ThreeManifold[];
  decide(a: ThreeSide, b: ThreeSide): Decision;
  distance(a: ThreeSide, b: ThreeSide, options?: DistanceOptions): Distance;
  contacts(a: ThreeSide, b: ThreeSide): Contacts;
  penetration(a: ThreeSide, b: ThreeSide): Penetration;
  /** The first hit of a ray or a raycaster, up to `far`; null: there is none. */
  cast(ray: Ray | Raycaster, far?: number): ThreeHit | null;
  /** Frees the World. The objects of three.js stay. */
  dispose(): void;
}
