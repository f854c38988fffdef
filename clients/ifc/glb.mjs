// Writes binary glTF 2.0: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html, section 4.4.

const FLOAT = 5126, UNSIGNED_INT = 5125, VERTICES = 34962, INDICES = 34963;

/** Collects meshes and nodes. The same calls give the same bytes. */
export class Glb {
    constructor(asset) {
        this.json = {asset: {version: '2.0', ...asset}, scene: 0, scenes: [{nodes: []}], nodes: [], meshes: [],
                     accessors: [], bufferViews: [], buffers: [{byteLength: 0}]};
        this.chunks = [];
    }

    /** Returns the number of the mesh. positions: Float32Array, x y z; indices: Uint32Array, three per triangle. */
    mesh(positions, indices) {
        const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
        for (let i = 0; i < positions.length; ++i) {
            least[i % 3] = Math.min(least[i % 3], positions[i]);
            most[i % 3] = Math.max(most[i % 3], positions[i]);
        }
        const position = this.#accessor(positions, VERTICES,
                                        {componentType: FLOAT, count: positions.length / 3, type: 'VEC3', min: least, max: most});
        const index = this.#accessor(indices, INDICES, {componentType: UNSIGNED_INT, count: indices.length, type: 'SCALAR'});
        this.json.meshes.push({primitives: [{attributes: {POSITION: position}, indices: index}]});
        return this.json.meshes.length - 1;
    }

    /** Adds a node below another, or below the scene if `parent` is undefined. Returns its number. */
    node(node, parent) {
        const number = this.json.nodes.push(node) - 1;
        const above = parent === undefined ? this.json.scenes[0] : this.json.nodes[parent];
        const list = parent === undefined ? 'nodes' : 'children';
        (above[list] ??= []).push(number);
        return number;
    }

    #accessor(array, target, accessor) {
        const bytes = Buffer.from(array.buffer, array.byteOffset, array.byteLength);
        const view = {buffer: 0, byteOffset: this.json.buffers[0].byteLength, byteLength: bytes.length, target};
        this.json.buffers[0].byteLength += bytes.length; // a multiple of 4, as all arrays hold 4-byte numbers
        this.chunks.push(bytes);
        this.json.bufferViews.push(view);
        this.json.accessors.push({bufferView: this.json.bufferViews.length - 1, ...accessor});
        return this.json.accessors.length - 1;
    }

    /** The parts of the file, in order. */
    bytes() {
        const chunk = (type, parts, fill) => {
            const length = parts.reduce((sum, part) => sum + part.length, 0), padded = Math.ceil(length / 4) * 4;
            const head = Buffer.alloc(8);
            head.writeUInt32LE(padded, 0), head.write(type, 4, 'latin1');
            return [head, ...parts, Buffer.alloc(padded - length, fill)];
        };
        const body = [...chunk('JSON', [Buffer.from(JSON.stringify(this.json))], ' '), ...chunk('BIN\0', this.chunks, 0)];
        const head = Buffer.alloc(12);
        head.write('glTF', 0, 'latin1'), head.writeUInt32LE(2, 4);
        head.writeUInt32LE(body.reduce((sum, part) => sum + part.length, 12), 8);
        return [head, ...body];
    }
}
