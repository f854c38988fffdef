// Run by: node --test tests/
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath} from 'node:url';

const program = fileURLToPath(new URL('../oncollide-ifc.mjs', import.meta.url));
const house = fileURLToPath(new URL('house.ifc', import.meta.url));
const text = readFileSync(house, 'utf8');
let folder, number = 0;
before(() => folder = mkdtempSync(join(tmpdir(), 'oncollide-ifc-')));
after(() => rmSync(folder, {recursive: true}));

const run = (...words) => spawnSync(process.execPath, [program, ...words], {encoding: 'utf8', cwd: folder});
const write = (content, ending = '.ifc') => {
    const file = join(folder, `model${++number}${ending}`);
    writeFileSync(file, content);
    return file;
};

/** The parts of a GLB file: {path, mesh, extras, points (in the model's frame), closed}. */
function parts(file) {
    const bytes = readFileSync(file), length = bytes.readUInt32LE(12), binary = bytes.subarray(28 + length);
    assert.equal(bytes.toString('latin1', 0, 4), 'glTF');
    assert.equal(bytes.readUInt32LE(8), bytes.length);
    const json = JSON.parse(bytes.toString('utf8', 20, 20 + length)), found = [];
    const view = accessor => {
        const {bufferView, count, type} = json.accessors[accessor], numbers = count * (type === 'VEC3' ? 3 : 1);
        return {at: json.bufferViews[bufferView].byteOffset, numbers};
    };
    const visit = (number, path) => {
        const node = json.nodes[number], here = [...path, node.name];
        if (node.mesh !== undefined) {
            const [{attributes, indices}] = json.meshes[node.mesh].primitives, m = node.matrix, points = [];
            const {at, numbers} = view(attributes.POSITION), triangles = view(indices), keys = [];
            for (let i = 0; i < numbers; i += 3) {
                const [x, y, z] = [0, 4, 8].map(k => binary.readFloatLE(at + 4 * i + k));
                keys.push([x, y, z].join());
                points.push([0, 1, 2].map(row => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row]));
            }
            const edges = new Map(), count = (a, b, by) => edges.set(a + ' ' + b, (edges.get(a + ' ' + b) ?? 0) + by);
            for (let i = 0; i < triangles.numbers; i += 3) {
                const [a, b, c] = [0, 4, 8].map(k => keys[binary.readUInt32LE(triangles.at + 4 * i + k)]);
                for (const [from, to] of [[a, b], [b, c], [c, a]]) count(from, to, 1), count(to, from, -1);
            }
            found.push({path: here.join(' > '), mesh: node.mesh, extras: node.extras, points,
                        closed: [...edges.values()].every(sum => sum === 0)});
        }
        for (const child of node.children ?? []) visit(child, here);
    };
    for (const root of json.scenes[0].nodes) visit(root, []);
    return {json, found};
}

function box(points) {
    const range = axis => [Math.min(...points.map(p => p[axis])), Math.max(...points.map(p => p[axis]))];
    return [0, 1, 2].map(range);
}
function near(found, expected, error) {
    found.flat().forEach((value, k) => assert.ok(Math.abs(value - expected.flat()[k]) <= error, `${found} for ${expected}`));
}

test('elements stand in the tree of the building, with their class, type and storey', () => {
    const {status, stderr} = run(house, '-o', 'house.glb');
    assert.equal(status, 0, stderr);
    assert.equal(stderr, `oncollide-ifc: warning: ${house}: left out: 1 IfcOpeningElement, 1 IfcSpace\n` +
                             `oncollide-ifc: warning: ${house}: no triangles could be made of 1 element ('Nothing')\n`);
    const {json, found} = parts(join(folder, 'house.glb'));
    const floor = 'Plot 7 > House > Ground floor > ', upper = 'Plot 7 > House > Upper floor > ';
    assert.deepEqual(found.map(part => part.path), [
        floor + 'IfcWall > Wall/north: 300 mm über', floor + 'IfcWindow > Window',
        floor + 'IfcBeam > IfcBeam 4BEAM00000000000000001', upper + 'IfcColumn > Column', upper + 'IfcColumn > Column'
    ]);
    assert.deepEqual(found[2].extras, {class: 'IfcBeam', name: 'IfcBeam 4BEAM00000000000000001', guid: '4BEAM00000000000000001',
                                       type: 'HEA 200', storey: 'Ground floor', discipline: 'house'});
    assert.equal(found[1].extras.type, 'casement');
    assert.deepEqual(json.asset.extras, {schema: 'IFC4', elements: 5, segments: 24,
                                         leftOut: {IfcOpeningElement: 1, IfcSpace: 1}, withoutBody: ['Nothing']});
});

test('coordinates are metres, z up, without the rounding of floats far from the origin', () => {
    run(house, '-o', 'house.glb');
    const {found: [wall, window, beam, column, turned]} = parts(join(folder, 'house.glb'));
    const east = 452000, north = 5411000, at = (x, y, z) => [x.map(v => v + east), y.map(v => v + north), z];
    near(box(wall.points), at([0, 4], [-0.15, 0.15], [0, 3]), 2e-9); // a double's rounding at 5411000
    near(box(window.points), at([1.5, 2.5], [-0.04, 0.04], [1, 2]), 2e-9);
    near(box(beam.points), at([0.5, 0.7], [-1, 1], [2.5, 2.7]), 2e-9);
    near(box(column.points), at([0.5, 1.5], [2.8, 3.2], [3, 5.52]), 1e-6);
    near(box(turned.points), at([3 - 0.46, 3 + 0.46], [3 - 0.52, 3 + 0.52], [3, 5.52]), 1e-6);
    for (const part of [wall, window, beam, column]) assert.ok(part.closed, part.path);
    assert.ok(wall.points.some(p => Math.abs(p[0] - east - 1.5) < 1e-6), 'the opening is cut out');
});

test('an element of two bodies is one part, and equal elements share their mesh', () => {
    run(house, '-o', 'house.glb');
    const {json, found: [, , , column, turned]} = parts(join(folder, 'house.glb'));
    assert.equal(column.mesh, turned.mesh);
    assert.equal(json.meshes.length, 4);
});

test('the same model gives the same bytes', () => {
    run(house, '-o', 'one.glb'), run(house, '-o', 'two.glb');
    assert.deepEqual(readFileSync(join(folder, 'one.glb')), readFileSync(join(folder, 'two.glb')));
});

test('options: discipline, segments, y up', () => {
    assert.equal(run(house, '-o', 'a.glb', '--discipline', 'Structure', '--segments', '60', '--y-up').status, 0);
    const {json, found} = parts(join(folder, 'a.glb'));
    assert.equal(found[0].extras.discipline, 'Structure');
    assert.equal(json.nodes[0].name, 'house.ifc');
    assert.deepEqual(json.nodes[0].matrix.slice(4, 12), [0, 0, -1, 0, 0, 1, 0, 0]);
    assert.ok(found[3].points.length > 4 * 60);
    for (const words of [[], [house], ['-o', 'a.glb'], [house, '-o', 'a.glb', '--segments', '7'],
                         [house, '-o', 'a.glb', '--segments', '8.5'], [house, house, '-o', 'a.glb'], [house, '--nothing']])
        assert.equal(run(...words).status, 64, words.join(' '));
    assert.match(run('--help').stdout, /^Usage: oncollide-ifc/);
});

test('the file may be an open device, and a deflection is no error', () => {
    const file = join(folder, 'device.glb');
    const script = `exec 3>'${file}'; exec '${process.execPath}' '${program}' '${house}' -o /dev/fd/3 --deflection 1mm`;
    const {status, stderr} = spawnSync('/bin/sh', ['-c', script], {encoding: 'utf8'});
    assert.equal(status, 0, stderr);
    assert.match(stderr, /warning: .*house.ifc: the deflection does not apply to IFC: a full circle has 24 segments/);
    assert.equal(parts(file).found.length, 5);
});

test('without web-ifc the message says what to install', () => {
    const copy = join(folder, 'copy');
    mkdirSync(copy);
    for (const name of ['oncollide-ifc.mjs', 'ifc_model.mjs', 'glb.mjs']) copyFileSync(join(program, '..', name), join(copy, name));
    const {status, stderr} = spawnSync(process.execPath, [join(copy, 'oncollide-ifc.mjs'), house, '-o', join(folder, 'a.glb')],
                                       {encoding: 'utf8', env: {PATH: process.env.PATH}});
    assert.equal(status, 66);
    assert.equal(stderr, `oncollide-ifc: error: ${house}: web-ifc is not installed; run: npm ci --prefix '${copy}/'\n`);
});

test('names that move a cursor stay on one line', () => {
    const file = write(text.replace("'Nothing'", String.raw`'a\X\0A\X2\202E\X0\b'`));
    assert.equal(run(file, '-o', 'a.glb').stderr.split('\n').length, 3);
});

test('what is no whole IFC model is one line and leaves no file', () => {
    const house2 = text.replace(/IFC4/, 'IFC2X2'), cases = [
        [65, 'not an IFC file: it does not begin', write('solid cube\nendsolid\n')],
        [65, 'not an IFC file: it does not begin', write('')],
        [65, 'ifcXML', write('<?xml version="1.0"?><ifc/>')],
        [65, 'ifcZIP', write('PK\u0003\u0004')],
        [65, "its schema is 'AUTOMOTIVE_DESIGN'", write(text.replace("'IFC4'", "'AUTOMOTIVE_DESIGN'"))],
        [65, 'names no schema', write(text.replace(/FILE_SCHEMA.*\n/, ''))],
        [65, 'its schema is IFC2X2; supported: IFC2X3, IFC4', write(house2)],
        [65, 'the file is cut off', write(text.slice(0, text.length / 2))],
        [65, 'it holds no element with geometry', write(text.replace(/^#(37|54|68|89|96|110)=.*\n/gm, ''))],
        [66, 'ENOENT', join(folder, 'absent.ifc')],
        [66, 'EISDIR', folder],
    ];
    for (const [code, words, file] of cases) {
        const {status, stdout, stderr} = run(file, '-o', 'fault.glb');
        assert.equal(status, code, words + ': ' + stderr);
        assert.equal(stdout, '');
        assert.ok(stderr.startsWith(`oncollide-ifc: error: ${file}: `), stderr);
        assert.ok(stderr.includes(words), stderr);
        assert.equal(stderr.split('\n').length, 2, stderr);
        assert.ok(!existsSync(join(folder, 'fault.glb')));
    }
    assert.equal(run(house, '-o', 'no/folder.glb').status, 73);
    assert.ok(!readdirSync(folder).some(name => name.endsWith('.tmp')));
});

test('damaged lines end in success or in one line, never in a trace', () => {
    const lines = text.split('\n');
    for (let i = 20; i < lines.length - 3; i += 7) {
        const damaged = lines.filter((_, k) => k !== i).join('\n').replaceAll(`#${i},`, `#${i + 1},`);
        const {status, stderr} = run(write(damaged), '-o', 'damaged.glb');
        assert.ok([0, 65, 70].includes(status), `${status} ${stderr}`);
        assert.ok(!/\n\s+at /.test(stderr), stderr);
    }
});
