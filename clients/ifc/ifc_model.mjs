// Reads the elements of an IFC model through web-ifc: geometry, names, classes, types, and their place in the building.
import {createRequire} from 'node:module';

/** A fault that the user can mend; `code` is the exit code. */
export class Fault extends Error {
    constructor(code, message) {
        super(message);
        this.code = code;
    }
}

/** Classes with a shape that no clash concerns: room, hole, or a line of a drawing. Their subclasses count, too. */
const LEFT_OUT = ['IFCSPATIALELEMENT', 'IFCSPATIALSTRUCTUREELEMENT', 'IFCFEATUREELEMENTSUBTRACTION', 'IFCVIRTUALELEMENT',
                  'IFCANNOTATION', 'IFCGRID', 'IFCPORT', 'IFCSTRUCTURALACTIVITY', 'IFCSTRUCTURALITEM',
                  'IFCPOSITIONINGELEMENT', 'IFCLINEARPOSITIONINGELEMENT'];

export function loadWebIfc() {
    try {
        return createRequire(import.meta.url)('web-ifc');
    } catch (fault) {
        if (fault.code !== 'MODULE_NOT_FOUND') throw fault;
        const folder = new URL('.', import.meta.url).pathname;
        throw new Fault(66, `web-ifc is not installed; run: npm ci --prefix '${decodeURIComponent(folder)}'`);
    }
}

/** Refuses what is certainly no whole IFC file, since web-ifc reads such files as far as they go. */
function checkText(bytes) {
    const begin = bytes.subarray(0, 4096).toString('latin1').replace(/^\u00ef\u00bb\u00bf/, '').trimStart();
    if (begin.startsWith('PK')) throw new Fault(65, 'a zip archive (ifcZIP); unpack the .ifc file that it holds');
    if (begin.startsWith('<')) throw new Fault(65, 'an XML file (ifcXML?); export IFC as a STEP file (.ifc)');
    if (!begin.startsWith('ISO-10303-21')) throw new Fault(65, "not an IFC file: it does not begin with 'ISO-10303-21'");
    const header = bytes.subarray(0, bytes.indexOf('ENDSEC', 0, 'latin1') + 1 || 65536).toString('latin1');
    const schema = /FILE_SCHEMA\s*\(\s*\(\s*'([^']*)'/i.exec(header)?.[1];
    if (!schema) throw new Fault(65, 'not an IFC file: its header names no schema (FILE_SCHEMA)');
    if (!/^IFC/i.test(schema)) throw new Fault(65, `not an IFC file: its schema is '${schema}'; a STEP part has the ending .step`);
    if (!/^IFC(2X3|4|4X1|4X2|4X3)(_|$|\s)/i.test(schema.replace(/_ADD\d|_TC\d|_RC\d/gi, '')))
        throw new Fault(65, `its schema is ${schema}; supported: IFC2X3, IFC4, IFC4X1, IFC4X2, IFC4X3`);
    if (!/END-ISO-10303-21\s*;?/.test(bytes.subarray(Math.max(0, bytes.length - 4096)).toString('latin1')))
        throw new Fault(65, "the file is cut off: it does not end with 'END-ISO-10303-21;'");
    return schema;
}

/** web-ifc turns the z axis of IFC to y; this turns it back, without rounding. Column-major. */
function turnedBack(m) {
    const turned = [...m];
    for (let column = 0; column < 16; column += 4) turned[column + 1] = -m[column + 2] + 0, turned[column + 2] = m[column + 1];
    return turned;
}

/** The transformation from the frame of `b` to that of `a`, column-major; undefined if `a` is singular. Rounded, so that
 *  equal elements in different places have equal ones: to the precision of their places, which may be far away. */
function relative(a, b) {
    const [p, q, r, , s, t, u, , v, w, x] = a;
    const P = t * x - u * w, S = u * v - s * x, V = s * w - t * v, determinant = p * P + q * S + r * V;
    if (!Number.isFinite(1 / determinant)) return undefined;
    const back = [P, r * w - q * x, q * u - r * t, S, p * x - r * v, r * s - p * u, V, q * v - p * w, p * t - q * s]
                     .map(value => value / determinant);
    const reach = Math.max(...a.slice(12, 15).map(Math.abs), ...b.slice(12, 15).map(Math.abs)) / Math.hypot(p, q, r);
    const step = 2 ** Math.ceil(Math.log2(Math.max(1024, reach) * 2 ** -46));
    const result = [];
    for (let column = 0; column < 4; ++column) {
        const from = [0, 1, 2].map(row => b[4 * column + row] - (column === 3 ? a[12 + row] : 0));
        const grid = column === 3 ? step : 2 ** -36;
        for (let row = 0; row < 3; ++row) {
            const value = back[row] * from[0] + back[3 + row] * from[1] + back[6 + row] * from[2];
            result.push(Math.round(value / grid) * grid + 0);
        }
        result.push(column === 3 ? 1 : 0);
    }
    return result;
}

export class IfcModel {
    /** Throws Fault{65} for a file that cannot be read. segments: of a full circle. */
    static async open(bytes, segments) {
        const schema = checkText(bytes), webIfc = loadWebIfc(), api = new webIfc.IfcAPI();
        await api.Init(undefined, true);
        api.SetLogLevel(webIfc.LogLevel.LOG_LEVEL_OFF);
        let model = -1;
        try {
            model = api.OpenModel(bytes, {COORDINATE_TO_ORIGIN: false, CIRCLE_SEGMENTS: segments});
        } catch {
        }
        if (model < 0) throw new Fault(65, `web-ifc cannot open it (schema ${schema})`);
        return new IfcModel(webIfc, api, model, schema);
    }

    constructor(webIfc, api, model, schema) {
        Object.assign(this, {webIfc, api, model, schema});
        this.above = new Map(), this.types = new Map(), this.names = new Map(), this.geometries = new Map();
        const relate = (relation, one, many, into) => {
            for (const id of this.#ids(relation)) {
                const line = this.#line(id), to = line?.[one]?.value;
                for (const of of [line?.[many] ?? []].flat())
                    if (to !== undefined && of && !into.has(of.value)) into.set(of.value, to);
            }
        };
        relate('IFCRELCONTAINEDINSPATIALSTRUCTURE', 'RelatingStructure', 'RelatedElements', this.above);
        relate('IFCRELAGGREGATES', 'RelatingObject', 'RelatedObjects', this.above);
        relate('IFCRELNESTS', 'RelatingObject', 'RelatedObjects', this.above);
        relate('IFCRELFILLSELEMENT', 'RelatingOpeningElement', 'RelatedBuildingElement', this.above);
        relate('IFCRELVOIDSELEMENT', 'RelatingBuildingElement', 'RelatedOpeningElement', this.above);
        relate('IFCRELDEFINESBYTYPE', 'RelatingType', 'RelatedObjects', this.types);
    }

    #ids(type, inherited = false) {
        if (this.webIfc[type] === undefined) return [];
        return [...this.api.GetLineIDsWithType(this.model, this.webIfc[type], inherited)].sort((a, b) => a - b);
    }
    #line(id) {
        try {
            return this.api.GetLine(this.model, id);
        } catch {
            return undefined; // a reference to a line that does not exist
        }
    }
    #class(id) { return this.api.GetNameFromTypeCode(this.api.GetLineType(this.model, id)); }

    /** Site, building and storey above an element, each its name or class; undefined where there is none. */
    #place(id) {
        const place = {};
        const levels = [['storey', /^IfcBuildingStorey$/], ['building', /^Ifc(Building|Bridge|Facility.*|Road|Railway|MarineFacility)$/],
                        ['site', /^IfcSite$/]];
        const seen = new Set();
        for (let at = this.above.get(id); at !== undefined && !seen.has(at); at = this.above.get(at)) {
            seen.add(at);
            const of = this.#class(at);
            for (const [level, classes] of levels)
                if (classes.test(of) && !place[level]) place[level] = this.nameOf(at);
        }
        return place;
    }

    nameOf(id) {
        if (!this.names.has(id)) {
            const line = this.#line(id);
            this.names.set(id, [line?.Name?.value, line?.LongName?.value].find(text => text?.trim()) ?? this.#class(id));
        }
        return this.names.get(id);
    }

    /** True if the element should have a body: it has a representation that is no axis, footprint or outline. */
    #hasBody(line) {
        const shape = line?.Representation && this.#line(line.Representation.value);
        return (shape?.Representations ?? []).some(reference => {
            const one = this.#line(reference.value), of = one?.RepresentationIdentifier?.value;
            return of === 'Body' || of === 'Facetation' || of === 'Tessellation';
        });
    }

    /** Calls visit({id, matrix, key, geometries, class, name, guid, type, site, building, storey}) for each element with
     *  triangles, in the order of the lines. `geometries` are {id, matrix} in the element's frame, and elements of equal
     *  `key` have the same ones. Returns {leftOut, withoutBody}: by class the elements left out, and the names of
     *  elements of which no triangle could be made. */
    elements(visit) {
        const leftOut = new Map(), withoutBody = [];
        const out = new Set(LEFT_OUT.flatMap(type => this.#ids(type, true)));
        const ids = this.#ids('IFCPRODUCT', true);
        const meshes = new Map();
        const wanted = ids.filter(id => !out.has(id) || this.#class(id) === 'IfcSite');
        this.api.StreamMeshes(this.model, wanted, mesh => {
            const placed = [];
            for (let i = 0; i < mesh.geometries.size(); ++i) {
                const {geometryExpressID, flatTransformation} = mesh.geometries.get(i);
                if (this.#read(geometryExpressID).indices.length > 0)
                    placed.push({id: geometryExpressID, matrix: turnedBack(flatTransformation)});
            }
            meshes.set(mesh.expressID, placed);
        });
        for (const id of ids) {
            const of = this.#class(id);
            if (out.has(id) && of !== 'IfcSite') {
                if (this.#line(id)?.Representation) leftOut.set(of, (leftOut.get(of) ?? 0) + 1);
                continue;
            }
            const placed = meshes.get(id) ?? [];
            const line = this.#line(id);
            const guid = line?.GlobalId?.value ?? '', given = line?.Name?.value?.trim();
            const name = given || `${of} ${guid || '#' + id}`;
            if (placed.length === 0) {
                if (this.#hasBody(line)) withoutBody.push(name);
                continue;
            }
            const matrix = placed[0].matrix;
            const geometries = placed.map(
                (one, k) => ({id: one.id, matrix: k === 0 ? undefined : relative(matrix, one.matrix) ?? one.matrix}));
            const type = this.types.get(id);
            visit({
                id, matrix, geometries, key: JSON.stringify(geometries), class: of, name, guid,
                type: (type !== undefined && this.#line(type)?.Name?.value) || line?.ObjectType?.value || '',
                ...this.#place(id)
            });
        }
        return {leftOut, withoutBody};
    }

    /** Vertices and triangles as web-ifc gives them: positions (Float32Array), indices (Uint32Array). web-ifc frees them
     *  after each element. */
    #read(id) {
        if (!this.geometries.has(id)) {
            const geometry = this.api.GetGeometry(this.model, id);
            const vertices = this.api.GetVertexArray(geometry.GetVertexData(), geometry.GetVertexDataSize());
            const indices = new Uint32Array(this.api.GetIndexArray(geometry.GetIndexData(), geometry.GetIndexDataSize()));
            const positions = new Float32Array(vertices.length / 2); // a normal follows each position
            for (let i = 0; i < positions.length; ++i) positions[i] = vertices[6 * Math.floor(i / 3) + i % 3];
            geometry.delete();
            this.geometries.set(id, {positions, indices});
        }
        return this.geometries.get(id);
    }

    /** The geometries of an element as one, in the element's frame. */
    merged(geometries) {
        const parts = geometries.map(one => this.geometries.get(one.id));
        const positions = new Float32Array(parts.reduce((sum, part) => sum + part.positions.length, 0));
        const indices = new Uint32Array(parts.reduce((sum, part) => sum + part.indices.length, 0));
        let vertex = 0, index = 0;
        parts.forEach((part, k) => {
            const m = geometries[k].matrix, p = part.positions;
            for (let i = 0; i < part.indices.length; ++i) indices[index++] = part.indices[i] + vertex / 3;
            for (let i = 0; i < p.length; i += 3)
                for (let row = 0; row < 3; ++row)
                    positions[vertex++] =
                        m ? m[row] * p[i] + m[4 + row] * p[i + 1] + m[8 + row] * p[i + 2] + m[12 + row] : p[i + row];
        });
        return {positions, indices};
    }
}
