export { OncollideError, ready, whole } from './module.mjs';
export { pose } from './poses.mjs';
export {
  box, boxMesh, capsule, cone, convexHull, cylinder, ellipsoid, Geometry, halfSpace, load, mesh, occupancyMap, sphere,
  sphereMesh, terrain, torusKnotMesh, torusMesh,
} from './geometry.mjs';
export { collide, ContactKind, contacts, distance, penetration, RegionKind, Stage, Verdict, World } from './world.mjs';
