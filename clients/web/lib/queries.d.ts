// Queries of a World and their results.
import type { BodyList, Filter, Numbers, Pose, Vec3 } from './index.js';

/** A body, bodies, or a model at a pose; models and poses may be many. */
export type Side = BodyList | { model: BodyList; pose?: Pose | null };
/** A model that moves to another pose, over the time from 0 to 1; without `to` it rests. */
export type MovingSide = { model: BodyList; pose?: Pose | null; to?: Pose | null };

/** A result of one pair; of many pairs the same names hold typed arrays, with three numbers for each point. */
export interface Decision { verdict: number; kind: number; bound: number }
export interface Distance {
  /** Certified bounds, metres; both 0 where the two meet. */
  lower: number;
  upper: number;
  /** Triangles, or -1 for a cell of a map. */
  partA: number;
  partB: number;
  /** Nearest points. */
  pointA: Vec3;
  pointB: Vec3;
}
export interface DistanceOptions {
  /** Metres: how far apart the bounds may be. */
  tolerance?: number;
  /** Metres: farther pairs get a lower bound above it alone. */
  cutoff?: number;
}
/** Pairs of parts that meet, as columns. */
export interface Contacts {
  partA: Int32Array;
  partB: Int32Array;
  /** Values of ContactKind. */
  kind: Uint8Array;
  /** Ends of the segment that two triangles share, three numbers each. */
  start: Float64Array;
  end: Float64Array;
  normalA: Float64Array;
  normalB: Float64Array;
  /** Of many pairs: contacts offsets[i] to offsets[i + 1] belong to pair i. */
  offsets?: Uint32Array;
}
export interface Penetration {
  supported: boolean;
  /** Certified bounds of how deep the deepest point of one lies inside the other. */
  depth: number;
  depthUpper: number;
  ofA: boolean;
  deepest: Vec3;
  thickness: number;
  /** Of two shapes: the least translation that parts them, along partingAlong. */
  partingLower: number;
  partingUpper: number;
  partingAlong: Vec3;
}
export interface SweepOptions {
  path?: 'linear' | 'screw';
  timeTolerance?: number;
  gapTolerance?: number;
  mostSteps?: number;
  stop?: 'contact' | 'touch' | 'press';
}
export interface Sweep {
  verdict: number;
  kind: number;
  /** Certified: they do not meet at any earlier time. */
  clearUntil: number;
  grazesUntil: number;
  /** Certainly met by then; Infinity: never. */
  contactBy: number;
  gap: number;
  point: Vec3;
  normal: Vec3;
}
export interface Region {
  /** A value of RegionKind. */
  kind: number;
  open: boolean;
  /** From a to b. */
  normal: Vec3;
  normalError: number;
  depthLower: number;
  depthUpper: number;
  /** Its points. */
  first: number;
  count: number;
  area: number;
  volume: number;
  lost: number;
}
export interface ManifoldOptions {
  /** Metres: parts of surfaces this near are regions, too. */
  margin?: number;
  /** At least 1; 4 by default. */
  pointsPerRegion?: number;
  /** At least 1; 16 by default. */
  regionsPerPair?: number;
  /** Also the regions' area, volume and `lost`. */
  measures?: boolean;
}
export interface ManifoldPoints {
  pointA: Float64Array;
  pointB: Float64Array;
  normal: Float64Array;
  /** Metres; negative: apart. */
  depth: Float64Array;
  depthError: Float64Array;
}
/** The manifolds of a step: regions offsets[i] up to offsets[i + 1] belong to pair i, of the bodies a[i] and b[i]. */
export interface FrameManifolds {
  a: Float64Array;
  b: Float64Array;
  regions: Region[];
  points: ManifoldPoints;
  offsets: Uint32Array;
  /** For each pair: 0 if a limit left out a region or a point. */
  complete: Uint8Array;
}
export interface Manifold {
  regions: Region[];
  points: ManifoldPoints;
  complete: boolean | Uint8Array;
  offsets?: Uint32Array;
}

/** Queries of two sides, as the World is now; layers and groups do not matter. With many on a side, results are columns. */
export interface Pairs {
  /** The verdict that step() would give. */
  decide(a: number, b: number): Decision;
  decide(a: Side, b: Side): any;
  distance(a: number, b: number, options?: DistanceOptions): Distance;
  distance(a: Side, b: Side, options?: DistanceOptions): any;
  contacts(a: Side, b: Side): Contacts;
  penetration(a: number, b: number): Penetration;
  penetration(a: Side, b: Side): any;
  /** When two moving models first meet. */
  sweep(a: MovingSide, b: MovingSide, options?: SweepOptions): Sweep | any;
  /** Contacts reduced to regions for a solver. */
  manifold(a: Side, b: Side, options?: ManifoldOptions): Manifold;
  /** Metres above the clearance: the largest error of a verdict `within`; by default, 1 % of the smaller body's diagonal. */
  maxError(a: number, b: number): number;
  maxError(a: Side, b: Side): any;
}

export interface Hits { body: Float64Array; verdict: Uint8Array; kind: Uint8Array; bound: Float64Array; offsets?: Uint32Array }
export interface CastHit {
  body: number;
  verdict: number;
  /** Certified bounds of where on the segment the hit is, 0 to 1. */
  fractionLower: number;
  fractionUpper: number;
  part: number;
  point: Vec3;
  normal: Vec3;
}
/** The first contact of a moving model; body is -1 if there is none. */
export interface SweepHit { body: number; verdict: number; kind: number; clearUntil: number; contactBy: number; gap: number; point: Vec3; normal: Vec3 }

/** Queries of one thing against all bodies. */
export interface Space {
  /** Bodies that a model at a pose, a segment or a box may meet. */
  overlaps(model: number, pose?: Pose | null, filter?: Filter): Hits;
  overlapsSegment(start: Numbers, end: Numbers, filter?: Filter): Hits;
  overlapsBox(low: Numbers, high: Numbers, filter?: Filter): Hits;
  /** The first body that a segment hits; null: none. Of many segments, columns with body -1 for none. */
  cast(start: Numbers, end: Numbers, filter?: Filter): any;
  castAll(start: Numbers, end: Numbers, filter?: Filter): CastHit[];
  castModel(model: number, start: Pose, end: Pose, options?: Filter & SweepOptions): SweepHit;
  castAllModel(model: number, start: Pose, end: Pose, options?: Filter & SweepOptions): SweepHit[];
  /** Bodies at most `cutoff` away from a model at a pose. */
  distances(model: number, pose: Pose | null, cutoff: number, options?: Filter & { tolerance?: number }): any;
}
