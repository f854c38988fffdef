#include <oncollide/narrowphase/gl/octant_shaders.hpp>

namespace oncollide::gl {

namespace {

constexpr const char* prelude = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Primitives { vec4 primitives[]; };
layout(std430, binding = 1) buffer Entries { uint entries[]; };
layout(std430, binding = 2) buffer Lists { uint lists[]; };  // 9 a list: where each octant's entries begin, and the end
layout(std430, binding = 6) buffer Out { uint tiles_wanted, entries_wanted, spare[2]; uint masks[]; }; // a byte a row
const uint none = 0xffffffffu;
uint lane() { return gl_GlobalInvocationID.x; }
uint stride() { return gl_NumWorkGroups.x * gl_WorkGroupSize.x; }
)";

constexpr const char* batch = R"(
layout(std430, binding = 3) readonly buffer Rows { uvec4 rows[]; };
layout(std430, binding = 4) coherent buffer Cursors { uint cursors[]; }; // 9 a row: entries an octant, then where the
                                                                         // next goes; and tiles that are not done
layout(std430, binding = 5) buffer Tiles { uint tiles[]; };      // 5 a tile: row, first, count, masks of 8 triangles
layout(location = 0) uniform uint row_count;
layout(location = 1) uniform uint tile_room;
layout(location = 2) uniform uint entry_room;

// A row holds, besides its cell, the parent's list (none: every primitive), its octant or the number of
// primitives, and its own list (none: not kept).
uint first_primitive(uint row) { return rows[3 * row + 2].x; }
uint parent_list(uint row) { return rows[3 * row + 2].y; }
uint octant_or_count(uint row) { return rows[3 * row + 2].z; }
uint own_list(uint row) { return rows[3 * row + 2].w; }
)";

constexpr const char* plan_main = R"(
void main()
{
    for (uint row = lane(); row < row_count; row += stride()) {
        for (uint k = 0; k < 8; ++k) cursors[9 * row + k] = 0;
        uint list = parent_list(row), first = 0, count = octant_or_count(row);
        if (list != none) {
            uint at = 9 * list + octant_or_count(row);
            first = lists[at];
            count = lists[at + 1] - first;
        }
        uint n = (count + 7) / 8, base = atomicAdd(tiles_wanted, n);
        cursors[9 * row + 8] = n;
        if (n == 0 && own_list(row) != none)
            for (uint k = 0; k < 9; ++k) lists[9 * own_list(row) + k] = 0;
        if (base + n > tile_room) continue; // the batch is repeated with more room
        for (uint i = 0; i < n; ++i) {
            uint tile = 5 * (base + i);
            tiles[tile] = row;
            tiles[tile + 1] = first + 8 * i;
            tiles[tile + 2] = min(count - 8 * i, 8);
        }
    }
}
)";

// This is the arithmetic of octant_kernel.cpp, operation by operation. `precise` forbids fusing operations, so the
// results have the same bits. In that kernel a lane is an octant; here a lane is a tile. The octants are symmetric,
// which saves work: along the cross product of an edge and an axis, their centres project only to d, t, -t and -d.
constexpr const char* test_main = R"(
uint apart(float lo, float hi, float shift, float r) { return lo - shift > r || hi - shift < -r ? none : 0u; }

uint apart4(float p, float q, float a, float b, float r, uint at_d, uint at_t, uint at_minus_t, uint at_minus_d)
{
    float lo = p < q ? p : q, hi = p < q ? q : p;
    precise float d = a - b, t = a + b;
    return apart(lo, hi, d, r) & at_d | apart(lo, hi, t, r) & at_t | apart(lo, hi, -t, r) & at_minus_t |
           apart(lo, hi, -d, r) & at_minus_d;
}

uint separated_by_edge(vec3 p, vec3 q, vec3 c, vec3 o, vec3 grown)
{
    precise vec3 e = q - p;
    vec3 f = abs(e);
    precise float px = e.y * p.z - e.z * p.y, cx = e.y * c.z - e.z * c.y, ax = e.y * o.z, bx = e.z * o.y;
    precise float py = e.z * p.x - e.x * p.z, cy = e.z * c.x - e.x * c.z, ay = e.z * o.x, by = e.x * o.z;
    precise float pz = e.x * p.y - e.y * p.x, cz = e.x * c.y - e.y * c.x, az = e.x * o.y, bz = e.y * o.x;
    precise float rx = f.y * grown.z + f.z * grown.y, ry = f.z * grown.x + f.x * grown.z,
                  rz = f.x * grown.y + f.y * grown.x;
    return apart4(px, cx, ax, bx, rx, 0xC0u, 0x30u, 0x0Cu, 0x03u) |
           apart4(py, cy, ay, by, ry, 0xA0u, 0x0Au, 0x50u, 0x05u) |
           apart4(pz, cz, az, bz, rz, 0x88u, 0x44u, 0x22u, 0x11u);
}

uint separated_by_face(vec3 normal, vec3 v, vec3 o, vec3 grown)
{
    precise float n0 = normal.x * v.x + normal.y * v.y + normal.z * v.z;
    precise float r = abs(normal.x) * grown.x + abs(normal.y) * grown.y + abs(normal.z) * grown.z;
    precise float x = normal.x * o.x, y = normal.y * o.y, z = normal.z * o.z;
    precise float xy = x + y, x_y = x - y; // octant k's centre projects to +-x +-y +-z, summed in this order
    precise float ppp = xy + z, mpp = -x_y + z, pmp = x_y + z, mmp = -xy + z;
    return apart(n0, n0, -mmp, r) & 0x08u | apart(n0, n0, mmp, r) & 0x10u | apart(n0, n0, -pmp, r) & 0x04u |
           apart(n0, n0, pmp, r) & 0x20u | apart(n0, n0, -mpp, r) & 0x02u | apart(n0, n0, mpp, r) & 0x40u |
           apart(n0, n0, -ppp, r) & 0x01u | apart(n0, n0, ppp, r) & 0x80u;
}

uint sides(bvec3 low, bvec3 high)
{
    return ((low.x ? 0x55u : 0u) | (high.x ? 0xAAu : 0u)) & ((low.y ? 0x33u : 0u) | (high.y ? 0xCCu : 0u)) &
           ((low.z ? 0x0Fu : 0u) | (high.z ? 0xF0u : 0u));
}

// The octants that a primitive enters.
uint octants(uint id, vec3 centre, vec3 half_size, float slack, bool boxes)
{
    vec4 p0 = primitives[3 * id], p1 = primitives[3 * id + 1], p2 = primitives[3 * id + 2];
    precise vec3 a = p0.xyz - centre, b = p1.xyz - centre, c = p2.xyz - centre, outer = half_size + slack;
    vec3 lo = min(min(a, b), c), hi = max(max(a, b), c), inner = vec3(slack);
    bvec3 low = bvec3(uvec3(lessThanEqual(lo, inner)) & uvec3(greaterThanEqual(hi, -outer)));
    bvec3 high = bvec3(uvec3(greaterThanEqual(hi, -inner)) & uvec3(lessThanEqual(lo, outer)));
    uint mask = sides(low, high);
    bool one = (mask & (mask - 1u)) == 0u;
    bool whole = all(greaterThanEqual(lo, -outer)) && all(lessThanEqual(hi, outer));
    if (mask == 0u || boxes || one && whole) return mask;
    precise vec3 o = 0.5 * half_size, grown = o + slack;
    return mask & ~(separated_by_face(vec3(p0.w, p1.w, p2.w), a, o, grown) | separated_by_edge(a, b, c, o, grown) |
                    separated_by_edge(b, c, a, o, grown) | separated_by_edge(c, a, b, o, grown));
}

// Room for a row's list, once its last tile is done.
void place(uint row)
{
    memoryBarrierBuffer();
    uint counts[8], count = 0;
    for (uint k = 0; k < 8; ++k) count += counts[k] = cursors[9 * row + k];
    uint at = atomicAdd(entries_wanted, count), list = own_list(row);
    for (uint k = 0; k < 8; ++k) {
        lists[9 * list + k] = at;
        cursors[9 * row + k] = at;
        at += counts[k];
    }
    lists[9 * list + 8] = at;
}

void main()
{
    if (tiles_wanted > tile_room) return;
    for (uint tile = lane(); tile < tiles_wanted; tile += stride()) {
        uint row = tiles[5 * tile], first = tiles[5 * tile + 1], count = tiles[5 * tile + 2];
        uvec4 where = rows[3 * row], size = rows[3 * row + 1];
        vec3 centre = uintBitsToFloat(where.xyz), half_size = uintBitsToFloat(size.xyz);
        float slack = uintBitsToFloat(where.w);
        bool every = parent_list(row) == none, boxes = size.w != 0u;
        uint base = first_primitive(row), grey = 0u, found[2] = uint[2](0u, 0u), counts = 0u; // counts: 4 bits an octant
        for (uint i = 0; i < count; ++i) {
            uint id = every ? first + i : entries[first + i];
            uint mask = octants(base + id, centre, half_size, slack, boxes);
            grey |= mask;
            found[i >> 2] |= mask << 8 * (i & 3);
            uint ones = mask; // a bit an octant spread to a nibble each
            ones = (ones | ones << 12) & 0x000F000Fu;
            ones = (ones | ones << 6) & 0x03030303u;
            counts += (ones | ones << 3) & 0x11111111u;
        }
        tiles[5 * tile + 3] = found[0];
        tiles[5 * tile + 4] = found[1];
        if (grey != 0u) atomicOr(masks[row >> 2], grey << 8 * (row & 3));
        if (own_list(row) == none) continue;
        for (uint k = 0; k < 8; ++k)
            if ((grey >> k & 1u) != 0u) atomicAdd(cursors[9 * row + k], counts >> 4 * k & 15u);
        memoryBarrierBuffer();
        if (atomicAdd(cursors[9 * row + 8], none) == 1u) place(row);
    }
}
)";

constexpr const char* scatter_main = R"(
void main()
{
    if (tiles_wanted > tile_room || entries_wanted > entry_room) return;
    for (uint tile = lane(); tile < tiles_wanted; tile += stride()) {
        uint row = tiles[5 * tile], first = tiles[5 * tile + 1], count = tiles[5 * tile + 2];
        if (own_list(row) == none) continue;
        uint found[2] = uint[2](tiles[5 * tile + 3], tiles[5 * tile + 4]);
        bool every = parent_list(row) == none;
        for (uint k = 0; k < 8; ++k) {
            uint lo = found[0] >> k & 0x01010101u, hi = found[1] >> k & 0x01010101u;
            if ((lo | hi) == 0u) continue;
            uint at = atomicAdd(cursors[9 * row + k], uint(bitCount(lo) + bitCount(hi)));
            for (uint i = 0; i < count; ++i)
                if ((found[i >> 2] >> 8 * (i & 3) >> k & 1u) != 0u)
                    entries[at++] = every ? first + i : entries[first + i];
        }
    }
}
)";

// One group per job.
constexpr const char* jobs = R"(
layout(std430, binding = 3) writeonly buffer Packed { uint packed_entries[]; };
layout(std430, binding = 4) buffer Jobs { uvec2 jobs[]; };
layout(location = 0) uniform uint job_count;
layout(location = 2) uniform uint entry_room;
shared uint target;

void copy(uint first, uint count)
{
    if (gl_LocalInvocationID.x == 0) target = atomicAdd(entries_wanted, count);
    barrier();
    uint base = target;
    barrier();
    if (base + count > entry_room) return;
    for (uint i = gl_LocalInvocationID.x; i < count; i += 64) packed_entries[base + i] = entries[first + i];
}
)";

constexpr const char* pack_main = R"(
void main()
{
    for (uint job = gl_WorkGroupID.x; job < job_count; job += gl_NumWorkGroups.x) {
        uint list = 9 * jobs[job].x, first = lists[list];
        uint count = lists[list + 8] - first;
        barrier();
        copy(first, count);
        if (gl_LocalInvocationID.x < 9) lists[list + gl_LocalInvocationID.x] += target - first;
        barrier();
    }
}
)";

constexpr const char* read_main = R"(
void main()
{
    for (uint job = gl_WorkGroupID.x; job < job_count; job += gl_NumWorkGroups.x) {
        uint at = 9 * jobs[job].x + jobs[job].y, first = lists[at];
        uint count = lists[at + 1] - first;
        barrier();
        copy(first, count);
        if (gl_LocalInvocationID.x == 0) jobs[job] = uvec2(target, count);
        barrier();
    }
}
)";

} // namespace

std::string OctantShaders::plan()
{
    return std::string(prelude) + batch + plan_main;
}
std::string OctantShaders::test()
{
    return std::string(prelude) + batch + test_main;
}
std::string OctantShaders::scatter()
{
    return std::string(prelude) + batch + scatter_main;
}
std::string OctantShaders::pack()
{
    return std::string(prelude) + jobs + pack_main;
}
std::string OctantShaders::read()
{
    return std::string(prelude) + jobs + read_main;
}

} // namespace oncollide::gl
