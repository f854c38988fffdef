// three-mesh-bvh for the adapter three_mesh_bvh.cpp. Messages in both directions are doubles. A message on standard input
// begins with their count. It is a query, which the script prepares, or empty; then the script runs the last query. The
// reply, on file 3: it works (1 or 0), seconds, the two meet (1 or 0), distance, time, has points (1 or 0), point on a, on b.
import {readSync, writeSync} from 'node:fs';

import {Box3, BufferAttribute, BufferGeometry, DoubleSide, Matrix4, Ray, Sphere, Vector3} from 'three';
import {MeshBVH} from 'three-mesh-bvh';

/** Ends the program at the end of the input. */
function read(count) {
    const numbers = new Float64Array(count), bytes = new Uint8Array(numbers.buffer);
    for (let at = 0; at < bytes.length;) {
        const read = readSync(0, bytes, at, bytes.length - at);
        if (read === 0) process.exit();
        at += read;
    }
    return numbers;
}

class Message {
    constructor(numbers) {
        this.numbers = numbers;
        this.at = 0;
    }
    take(count) {
        return this.numbers.subarray(this.at, this.at += count);
    }
    number() {
        return this.take(1)[0];
    }
    vector() {
        return new Vector3(...this.take(3));
    }
    pose() {
        const r = this.take(9), p = this.take(3);
        return new Matrix4().set(r[0], r[1], r[2], p[0], r[3], r[4], r[5], p[1], r[6], r[7], r[8], p[2], 0, 0, 0, 1);
    }
    mesh() {
        const pose = this.pose(), vertices = this.number(), triangles = this.number();
        const geometry = new BufferGeometry();
        geometry.setAttribute('position', new BufferAttribute(new Float32Array(this.take(3 * vertices)), 3));
        geometry.setIndex(new BufferAttribute(new Uint32Array(this.take(3 * triangles)), 1));
        geometry.boundsTree = new MeshBVH(geometry);
        return {geometry, pose, tree: geometry.boundsTree};
    }
}

/** The matrix that takes points of one frame to another. */
const between = (from, to) => to.clone().invert().multiply(from);

// Each reads its query, and returns a function to measure and another that fills the reply from its result.
const queries = {
    meet(message) {
        const a = message.mesh(), b = message.mesh(), into = between(b.pose, a.pose);
        return [() => a.tree.intersectsGeometry(b.geometry, into), (met, reply) => reply.meet = met];
    },
    distance(message) {
        const a = message.mesh(), b = message.mesh(), into = between(b.pose, a.pose), onA = {}, onB = {};
        return [
            () => a.tree.closestPointToGeometry(b.geometry, into, onA, onB),
            (found, reply) => {
                if (!found) throw new Error('no nearest point');
                reply.meet = found.distance === 0, reply.distance = found.distance;
                reply.points = [onA.point.clone().applyMatrix4(a.pose), onB.point.clone().applyMatrix4(b.pose)];
            },
        ];
    },
    // three requires unit directions. They are rounded, and so some rays pass beside the vertex or edge in their way.
    ray(message) {
        const a = message.mesh(), from = message.vector(), motion = message.vector(), length = motion.length();
        const ray = new Ray(from, motion.normalize()).applyMatrix4(a.pose.clone().invert());
        return [
            () => a.tree.raycastFirst(ray, DoubleSide, 0, length),
            (hit, reply) => {
                reply.meet = hit !== null && hit !== undefined;
                if (reply.meet) reply.time = hit.distance / length;
            },
        ];
    },
    sphere(message) {
        const a = message.mesh(), size = message.vector(), pose = message.pose();
        const sphere = new Sphere(new Vector3().applyMatrix4(between(pose, a.pose)), size.x);
        return [() => a.tree.intersectsSphere(sphere), (met, reply) => reply.meet = met];
    },
    box(message) {
        const a = message.mesh(), size = message.vector(), pose = message.pose(), into = between(pose, a.pose);
        const box = new Box3(size.clone().negate(), size);
        return [() => a.tree.intersectsBox(box, into), (met, reply) => reply.meet = met];
    },
};
const byNumber = [queries.meet, queries.distance, queries.ray, queries.sphere, queries.box];

function write({works = 1, seconds = 0, meet = false, distance = 0, time = 0, points}) {
    const place = points ? points.flatMap(p => p.toArray()) : new Array(6).fill(0);
    writeSync(3, new Float64Array([works, seconds, Number(meet), distance, time, Number(Boolean(points)), ...place]));
}

/** The least of three calls: the first ones run before the compiler has seen the code. */
function answer([run, fill]) {
    const reply = {};
    let least = Infinity, result;
    for (let call = 0; call < 3; ++call) {
        const start = process.hrtime.bigint();
        result = run();
        least = Math.min(least, Number(process.hrtime.bigint() - start));
    }
    reply.seconds = least * 1e-9;
    fill(result, reply);
    return reply;
}

for (let query = null;;) {
    const message = new Message(read(read(1)[0]));
    try {
        if (message.numbers.length > 0) {
            query = byNumber[message.number()](message);
            write({});
        } else {
            write(answer(query));
        }
    } catch {
        write({works: 0});
    }
}
