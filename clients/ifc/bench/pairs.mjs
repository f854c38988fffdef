// Finds the pairs of elements that meet in a GLB file of oncollide-ifc with three-mesh-bvh, and compares them with a JSON
// report of `oncollide clash MODEL.glb --units m -o report.json` on the same triangles:
//   npm ci && node pairs.mjs MODEL.glb report.json
import {readFileSync} from 'node:fs';
import {performance} from 'node:perf_hooks';

import {BufferAttribute, BufferGeometry, Matrix4} from 'three';
import {MeshBVH} from 'three-mesh-bvh';

const [modelFile, reportFile] = process.argv.slice(2);
if (!reportFile) throw new Error('expected MODEL.glb report.json');

/** The parts with their pose, and one geometry per mesh. */
function read(file) {
    const bytes = readFileSync(file), length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.toString('utf8', 20, 20 + length)), binary = bytes.subarray(28 + length);
    const array = (accessor, Type, numbers) => {
        const {bufferView, count} = json.accessors[accessor], {byteOffset} = json.bufferViews[bufferView];
        return new Type(binary.buffer.slice(binary.byteOffset + byteOffset, binary.byteOffset + byteOffset + 4 * numbers * count));
    };
    const geometries = json.meshes.map(({primitives: [{attributes, indices}]}) => {
        const geometry = new BufferGeometry();
        geometry.setAttribute('position', new BufferAttribute(array(attributes.POSITION, Float32Array, 3), 3));
        geometry.setIndex(new BufferAttribute(array(indices, Uint32Array, 1), 1));
        return geometry;
    });
    const parts = [], stem = file.replace(/^.*\//, '');
    const visit = (number, path) => {
        const node = json.nodes[number], here = [...path, node.name];
        if (node.mesh !== undefined)
            parts.push({path: `${stem}:${here.join('/')}`, geometry: geometries[node.mesh], pose: new Matrix4().fromArray(node.matrix)});
        for (const child of node.children ?? []) visit(child, here);
    };
    for (const root of json.scenes[0].nodes) visit(root, []);
    return parts;
}

const parts = read(modelFile);
const start = performance.now();
for (const part of parts) {
    part.geometry.boundsTree ??= new MeshBVH(part.geometry);
    part.geometry.computeBoundingBox();
    part.box = part.geometry.boundingBox.clone().applyMatrix4(part.pose);
    part.back = part.pose.clone().invert();
}
const built = performance.now();
parts.sort((a, b) => a.box.min.x - b.box.min.x);
const found = [];
let candidates = 0;
for (let i = 0; i < parts.length; ++i)
    for (let k = i + 1; k < parts.length && parts[k].box.min.x <= parts[i].box.max.x; ++k) {
        if (!parts[i].box.intersectsBox(parts[k].box)) continue;
        ++candidates;
        const into = new Matrix4().multiplyMatrices(parts[i].back, parts[k].pose);
        if (parts[i].geometry.boundsTree.intersectsGeometry(parts[k].geometry, into)) found.push([parts[i].path, parts[k].path]);
    }
const end = performance.now();

// Parts may have equal paths, so pairs of paths are counted.
const counted = pairs => pairs.reduce((counts, [a, b]) => {
    const key = a < b ? `${a}\n${b}` : `${b}\n${a}`;
    return counts.set(key, (counts.get(key) ?? 0) + 1);
}, new Map());
const report = JSON.parse(readFileSync(reportFile));
const meeting = report.clashes.filter(clash => !clash.distance);
const enclosed = meeting.filter(clash => clash.kind === 'enclosed').length;
const ours = counted(meeting.map(({a, b}) => [a.path, b.path])), theirs = counted(found);
const lacks = (from, of) => [...from].reduce((sum, [key, count]) => sum + Math.max(0, count - (of.get(key) ?? 0)), 0);
console.log(`${parts.length} elements, ${candidates} pairs with boxes that overlap`);
console.log(`three-mesh-bvh: ${found.length} pairs meet, ${(built - start).toFixed(0)} ms for trees, ${(end - built).toFixed(0)} ms for pairs`);
console.log(`oncollide: ${meeting.length} pairs meet, ${enclosed} of them enclosed`);
console.log(`missed by three-mesh-bvh: ${lacks(ours, theirs)}; found by it alone: ${lacks(theirs, ours)}`);
