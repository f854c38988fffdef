#!/usr/bin/env node
// Converts an IFC model to a GLB file whose nodes are the elements: see README.md.
import {closeSync, openSync, readFileSync, renameSync, rmSync, writevSync} from 'node:fs';
import {basename, extname} from 'node:path';
import {parseArgs} from 'node:util';

import {Glb} from './glb.mjs';
import {Fault, IfcModel, loadWebIfc} from './ifc_model.mjs';

const USAGE = `Usage: oncollide-ifc MODEL.ifc -o MODEL.glb [--discipline NAME] [--segments N] [--y-up]
  -o, --out FILE       the GLB file to write
  --discipline NAME    of all elements of the file (default: the file's name without .ifc)
  --segments N         straight pieces of a full circle, 8 to 360 (default 24)
  --y-up               turn the model as viewers of glTF expect it; without it z is up, as in IFC
  --version            the version of web-ifc
Exit codes: 0 success, 64 usage, 65 not a whole IFC file or no geometry, 66 the file cannot be read or web-ifc is not
installed, 70 a fault of web-ifc or of this program, 73 the GLB file cannot be written.`;

function options() {
    let parsed;
    try {
        parsed = parseArgs({
            allowPositionals: true,
            options: {
                out: {type: 'string', short: 'o'}, discipline: {type: 'string'}, segments: {type: 'string', default: '24'},
                'y-up': {type: 'boolean'}, deflection: {type: 'string'}, help: {type: 'boolean', short: 'h'},
                version: {type: 'boolean'}
            }
        });
    } catch (fault) {
        throw new Fault(64, fault.message);
    }
    const {values, positionals} = parsed, segments = Number(values.segments);
    if (values.help) return null;
    if (values.version) return {version: true};
    if (positionals.length !== 1 || !values.out) throw new Fault(64, 'expected MODEL.ifc -o MODEL.glb; see --help');
    if (!Number.isInteger(segments) || segments < 8 || segments > 360)
        throw new Fault(64, `--segments ${values.segments}: expected a whole number from 8 to 360`);
    const file = positionals[0];
    return {file, out: values.out, segments, yUp: values['y-up'],
            deflection: values.deflection,
            discipline: values.discipline ?? basename(file, extname(file))};
}

function read(file) {
    try {
        return readFileSync(file);
    } catch (fault) {
        throw new Fault(66, fault.message.replace(/^(\w+): (.*?), .*$/, '$2 ($1)'));
    }
}

/** The file appears whole or not at all, unless it is a device such as /dev/fd/3. */
function write(file, parts) {
    const isDevice = file.startsWith('/dev/'), temporary = isDevice ? file : `${file}.${process.pid}.tmp`;
    try {
        const to = openSync(temporary, isDevice ? 'w' : 'wx');
        try {
            for (const part of parts)
                for (let at = 0; at < part.length;) at += writevSync(to, [part.subarray(at)]);
        } finally {
            closeSync(to);
        }
        if (!isDevice) renameSync(temporary, file);
    } catch (fault) {
        if (!isDevice) rmSync(temporary, {force: true});
        throw new Fault(73, `${file}: ${fault.message}`);
    }
}

const quoted = names => names.slice(0, 3).map(name => `'${name}'`).join(', ') + (names.length > 3 ? ', ...' : '');

const version = () =>
    `web-ifc ${JSON.parse(readFileSync(new URL('package.json', import.meta.url))).dependencies['web-ifc']}`;

/** Returns what the user should know. */
async function convert({file, out, discipline, segments, yUp, deflection}) {
    const model = await IfcModel.open(read(file), segments);
    const glb = new Glb({generator: `oncollide-ifc (${version()})`});
    const root = yUp ? glb.node({name: basename(file), matrix: [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]}) : undefined;
    const folders = new Map(), meshes = new Map();
    const below = names => names.reduce((above, name, depth) => {
        const key = JSON.stringify(names.slice(0, depth + 1));
        if (!folders.has(key)) folders.set(key, glb.node({name}, above));
        return folders.get(key);
    }, root);
    let elements = 0;
    const {leftOut, withoutBody} = model.elements(element => {
        if (!meshes.has(element.key)) {
            const {positions, indices} = model.merged(element.geometries);
            meshes.set(element.key, glb.mesh(positions, indices));
        }
        const {class: of, name, guid, type, site, building, storey} = element;
        glb.node({name, mesh: meshes.get(element.key), matrix: element.matrix,
                  extras: {class: of, name, guid, type, storey: storey ?? '', discipline}},
                 below([site, building, storey, of].filter(level => level !== undefined)));
        ++elements;
    });
    if (elements === 0) throw new Fault(65, 'it holds no element with geometry');
    const notes = [];
    if (deflection) notes.push(`the deflection does not apply to IFC: a full circle has ${segments} segments`);
    if (leftOut.size > 0)
        notes.push('left out: ' + [...leftOut].sort().map(([of, count]) => `${count} ${of}`).join(', '));
    if (withoutBody.length > 0)
        notes.push(`no triangles could be made of ${withoutBody.length} element${withoutBody.length === 1 ? '' : 's'} ` +
                   `(${quoted(withoutBody)})`);
    glb.json.asset.extras = {schema: model.schema, elements, segments, leftOut: Object.fromEntries([...leftOut].sort()), withoutBody};
    write(out, glb.bytes());
    return notes;
}

/** One line, without characters that move a cursor. */
const printable = text => text.replace(/[\u0000-\u001f\u007f-\u009f\u2028-\u202e\u2066-\u2069]+/g, ' ');

async function main() {
    let asked;
    try {
        asked = options();
        if (!asked) console.log(USAGE);
        else if (asked.version) loadWebIfc(), console.log(version());
        else for (const note of await convert(asked)) console.error(printable(`oncollide-ifc: warning: ${asked.file}: ${note}`));
        return 0;
    } catch (fault) {
        const known = fault instanceof Fault, where = asked?.file && fault.code !== 73 ? `${asked.file}: ` : '';
        console.error(printable(`oncollide-ifc: error: ${where}${known ? fault.message : `web-ifc failed: ${fault?.message ?? fault}`}`));
        return known ? fault.code : 70;
    }
}

process.exitCode = await main();
