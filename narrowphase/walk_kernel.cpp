// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/broadphase/simd.hpp>
#include <oncollide/narrowphase/walk_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// Other threads walk the same trees: masks do not change meanwhile, stamps are all written alike.
inline std::uint32_t visit(OcstNode& node, std::uint32_t stamp)
{
    const std::uint32_t state = __atomic_load_n(&node.state, __ATOMIC_RELAXED);
    const std::uint32_t stamped = (state & ((1u << OcstNode::stamp_shift) - 1)) | stamp;
    if (state & OcstNode::expanded_bit && stamped != state) __atomic_store_n(&node.state, stamped, __ATOMIC_RELAXED);
    return state;
}

inline std::uint32_t child(const OcstNode& node, unsigned grey, unsigned octant)
{
    return node.first_child + static_cast<std::uint32_t>(__builtin_popcount(grey & ((1u << octant) - 1)));
}

inline CellKey below(CellKey key, unsigned octant)
{
    return key << 3 | octant;
}

/// All-ones lanes where `grey` has a bit.
inline I32x8 lanes_of(unsigned grey)
{
    const I32x8 lane{1, 2, 4, 8, 16, 32, 64, 128};
    const int g = static_cast<int>(grey);
    return (I32x8{g, g, g, g, g, g, g, g} & lane) != 0;
}

/// Cells as the tests see them, eight at a time: ball (x, y, z, r), and slab of half-thickness h across the unit vector
/// n.
struct Cells {
    F32x8 x, y, z, r, nx, ny, nz, h;
};
constexpr int cell_columns = sizeof(Cells) / sizeof(F32x8);

/// One of them, in every lane.
inline Cells spread(const float (&columns)[cell_columns][8], unsigned lane)
{
    return {splat(columns[0][lane]), splat(columns[1][lane]), splat(columns[2][lane]), splat(columns[3][lane]),
            splat(columns[4][lane]), splat(columns[5][lane]), splat(columns[6][lane]), splat(columns[7][lane])};
}

template <class Bytes>
inline F32x8 widen(const void* bytes)
{
    Bytes v;
    __builtin_memcpy(&v, bytes, 8);
    return __builtin_convertvector(__builtin_convertvector(v, I32x8), F32x8);
}
inline F32x8 widen(const std::int8_t (&bytes)[8])
{
    using I8x8 = std::int8_t __attribute__((vector_size(8)));
    return widen<I8x8>(static_cast<const void*>(bytes));
}
inline F32x8 widen(const std::uint8_t (&bytes)[8])
{
    using U8x8 = std::uint8_t __attribute__((vector_size(8)));
    return widen<U8x8>(static_cast<const void*>(bytes));
}

/// In the frame of their own side, relative to the octants' centres.
inline Cells decode(const TightBlock& block, const float (&unit)[4], float size)
{
    Cells c{widen(block.x) * (unit[0] * size),
            widen(block.y) * (unit[1] * size),
            widen(block.z) * (unit[2] * size),
            widen(block.r) * (unit[3] * size),
            widen(block.nx),
            widen(block.ny),
            widen(block.nz),
            widen(block.h) * (unit[3] * size)};
    const F32x8 inverse = 1 / sqrt(c.nx * c.nx + c.ny * c.ny + c.nz * c.nz);
    c.nx = c.nx * inverse, c.ny = c.ny * inverse, c.nz = c.nz * inverse;
    return c;
}

inline Cells decode(const TightCell& cell, const float (&unit)[4], float size)
{
    TightBlock block;
    for (unsigned k = 0; k < 8; ++k) {
        block.x[k] = cell.x, block.y[k] = cell.y, block.z[k] = cell.z, block.r[k] = cell.r;
        block.nx[k] = cell.nx, block.ny[k] = cell.ny, block.nz[k] = cell.nz, block.h[k] = cell.h;
    }
    return decode(block, unit, size);
}

inline TightCell cell_of(const TightBlock& b, unsigned k)
{
    return {b.x[k], b.y[k], b.z[k], b.r[k], b.nx[k], b.ny[k], b.nz[k], b.h[k]};
}

inline void turn(const float (&m)[9], F32x8& x, F32x8& y, F32x8& z)
{
    const F32x8 u = x, v = y, w = z;
    x = m[0] * u + m[1] * v + m[2] * w, y = m[3] * u + m[4] * v + m[5] * w, z = m[6] * u + m[7] * v + m[8] * w;
}

inline F32x8 abs(F32x8 v)
{
    return max(v, -v);
}

/// Distance that two cells keep at least; closer than `reach` they may touch. Balls first, then the two slabs: across
/// one cell's slab the other has its own half-thickness by the cosine between the two and its radius by the sine.
inline F32x8 gap_between(const Cells& p, const Cells& q, float reach, I32x8 grey)
{
    const F32x8 x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
    const F32x8 balls = sqrt(x * x + y * y + z * z) - (p.r + q.r);
    if (!bits((balls <= splat(reach)) & grey)) return balls;
    const F32x8 cosine = abs(p.nx * q.nx + p.ny * q.ny + p.nz * q.nz);
    const F32x8 sine = sqrt(max(1 - cosine * cosine, splat(0)) + 0x1p-18f);
    const F32x8 across_p = abs(p.nx * x + p.ny * y + p.nz * z) - p.h - min(q.r, q.h * cosine + q.r * sine);
    const F32x8 across_q = abs(q.nx * x + q.ny * y + q.nz * z) - q.h - min(p.r, p.h * cosine + p.r * sine);
    return max(balls, max(across_p, across_q));
}

/// A pair of cells opened: eight lanes of one side against some cells of the other.
struct Opened {
    Cells lanes;
    float others[cell_columns][8];
};

/// The lanes are A's children; or, with A not descended, B's.
inline void open_tight(const WalkPlan& plan, const WalkEntry& e, const WalkStep& step, Opened& opened)
{
    const bool open_a = step.scale_a != 0, open_b = step.scale_b != 0;
    Cells a =
        open_a ? decode(plan.tight_a[e.a], plan.unit_a, step.size_a) : decode(e.tight_a, plan.unit_a, step.size_a);
    Cells b =
        open_b ? decode(plan.tight_b[e.b], plan.unit_b, step.size_b) : decode(e.tight_b, plan.unit_b, step.size_b);
    a.x = a.x + load(plan.ax) * step.scale_a, a.y = a.y + load(plan.ay) * step.scale_a;
    a.z = a.z + load(plan.az) * step.scale_a;
    turn(plan.turn, b.x, b.y, b.z);
    turn(plan.turn, b.nx, b.ny, b.nz);
    b.x = b.x + (e.d[0] + load(plan.bx) * step.scale_b), b.y = b.y + (e.d[1] + load(plan.by) * step.scale_b);
    b.z = b.z + (e.d[2] + load(plan.bz) * step.scale_b);
    opened.lanes = open_a ? a : b;
    const Cells& others = open_a ? b : a;
    store(opened.others[0], others.x), store(opened.others[1], others.y), store(opened.others[2], others.z);
    store(opened.others[3], others.r), store(opened.others[4], others.nx), store(opened.others[5], others.ny);
    store(opened.others[6], others.nz), store(opened.others[7], others.h);
}

/// Lane k: child k of A against one child of B, or, with A not descended, A against child k of B.
struct Near {
    F32x8 distance; ///< squared, of the centres; of tight cells, the gap
    unsigned mask;  ///< lanes that touch and are grey
};

inline Near tell(F32x8 distance, float reach, I32x8 grey, F32x8& nearest)
{
    const I32x8 touch = distance <= splat(reach);
    nearest = min(nearest, (grey & ~touch) ? distance : splat(__builtin_inff()));
    return {distance, bits(touch & grey)};
}

inline F32x8 squared_distance(F32x8 x, F32x8 y, F32x8 z)
{
    return x * x + y * y + z * z;
}

template <bool tight>
WalkEnd walk(const WalkPlan& plan, WalkState& s)
{
    const F32x8 ax = load(plan.ax), ay = load(plan.ay), az = load(plan.az);
    const F32x8 bx = load(plan.bx), by = load(plan.by), bz = load(plan.bz);
    F32x8 nearest[most_steps];
    for (int i = 0; i < plan.count; ++i) nearest[i] = splat(__builtin_inff());
    const auto end = [&](WalkEnd how) {
        for (int i = 0; i < plan.count; ++i)
            for (int lane = 0; lane < 8; ++lane)
                if (nearest[i][lane] < s.nearest[i]) s.nearest[i] = nearest[i][lane];
        return how;
    };
    while (s.top) {
        if (s.leaves && s.leaf_count >= s.enough_leaves) return end(WalkEnd::leaves);
        const WalkEntry e = s.stack[--s.top];
        const WalkStep& step = plan.steps[e.step];
        const bool open_a = step.scale_a != 0, open_b = step.scale_b != 0;
        const std::uint32_t state_a = open_a ? visit(plan.nodes_a[e.a], plan.stamp) : OcstNode::expanded_bit;
        const std::uint32_t state_b = open_b ? visit(plan.nodes_b[e.b], plan.stamp) : OcstNode::expanded_bit;
        if (!(state_a & state_b & OcstNode::expanded_bit)) {
            if (s.parked_count == s.parked_room) {
                ++s.top;
                return end(WalkEnd::full);
            }
            s.parked[s.parked_count++] = e;
            continue;
        }
        ++s.node_pairs;
        const bool last = e.step + 1 == plan.count;
        const bool hold_a = tight && !last && plan.steps[e.step + 1].scale_a == 0;
        const bool hold_b = tight && !last && plan.steps[e.step + 1].scale_b == 0;
        const unsigned grey_a = state_a & 0xff, grey_b = state_b & 0xff;
        const I32x8 lanes = lanes_of(open_a ? grey_a : grey_b);
        const std::uint32_t first_pushed = s.top;
        float closest = __builtin_inff();
        std::uint32_t closest_at = first_pushed;

        const auto take = [&](const Near& near, unsigned other) {
            for (unsigned mask = near.mask; mask; mask &= mask - 1) {
                const auto k = static_cast<unsigned>(__builtin_ctz(mask));
                const unsigned oa = open_a ? k : other, ob = open_a ? other : k;
                WalkEntry& out = s.stack[s.top];
                out.key_a = open_a ? below(e.key_a, oa) : e.key_a;
                out.key_b = open_b ? below(e.key_b, ob) : e.key_b;
                if (last) {
                    s.hit_a = out.key_a, s.hit_b = out.key_b;
                    if (!s.leaves) return true;
                    s.leaves[s.leaf_count++] = {out.key_a, out.key_b, e.a, e.b};
                    continue;
                }
                out.a = open_a && !step.last_a ? child(plan.nodes_a[e.a], grey_a, oa) : e.a;
                out.b = open_b && !step.last_b ? child(plan.nodes_b[e.b], grey_b, ob) : e.b;
                out.d[0] = e.d[0] + plan.bx[ob] * step.scale_b - plan.ax[oa] * step.scale_a;
                out.d[1] = e.d[1] + plan.by[ob] * step.scale_b - plan.ay[oa] * step.scale_a;
                out.d[2] = e.d[2] + plan.bz[ob] * step.scale_b - plan.az[oa] * step.scale_a;
                out.step = e.step + 1;
                if (hold_a) out.tight_a = open_a ? cell_of(plan.tight_a[e.a], oa) : e.tight_a;
                if (hold_b) out.tight_b = open_b ? cell_of(plan.tight_b[e.b], ob) : e.tight_b;
                if (near.distance[k] < closest) closest = near.distance[k], closest_at = s.top;
                ++s.top;
            }
            return false;
        };

        const unsigned others = open_a ? (open_b ? grey_b : 1) : 1;
        if constexpr (tight) {
            Opened opened;
            open_tight(plan, e, step, opened);
            for (unsigned rest = others; rest; rest &= rest - 1) {
                const auto j = static_cast<unsigned>(__builtin_ctz(rest));
                const F32x8 gap = gap_between(opened.lanes, spread(opened.others, j), plan.reach, lanes);
                if (take(tell(gap, plan.reach, lanes, nearest[e.step]), j)) return WalkEnd::hit;
            }
        } else {
            const F32x8 x = e.d[0] + bx * step.scale_b, y = e.d[1] + by * step.scale_b, z = e.d[2] + bz * step.scale_b;
            if (open_a) {
                const F32x8 oax = ax * step.scale_a, oay = ay * step.scale_a, oaz = az * step.scale_a;
                alignas(32) float child_x[8], child_y[8], child_z[8]; // of B's children, to broadcast one at a time
                store(child_x, x), store(child_y, y), store(child_z, z);
                for (unsigned rest = others; rest; rest &= rest - 1) {
                    const auto j = static_cast<unsigned>(__builtin_ctz(rest));
                    const F32x8 d2 =
                        squared_distance(splat(child_x[j]) - oax, splat(child_y[j]) - oay, splat(child_z[j]) - oaz);
                    if (take(tell(d2, step.reach2, lanes, nearest[e.step]), j)) return WalkEnd::hit;
                }
            } else if (take(tell(squared_distance(x, y, z), step.reach2, lanes, nearest[e.step]), 0)) {
                return WalkEnd::hit;
            }
        }
        if (s.top > first_pushed) { // the closest pair next: deep contacts end the walk soonest
            const WalkEntry t = s.stack[closest_at];
            s.stack[closest_at] = s.stack[s.top - 1];
            s.stack[s.top - 1] = t;
        }
    }
    return end(WalkEnd::empty);
}

inline unsigned digit(CellKey key, int below_it)
{
    return key >> 3 * below_it & 7;
}

template <bool tight>
bool replay(const WalkPlan& plan, CellKey key_a, CellKey key_b)
{
    int left_a = 0, left_b = 0; // levels still to go down on each side
    for (int i = 0; i < plan.count; ++i) left_a += plan.steps[i].scale_a != 0, left_b += plan.steps[i].scale_b != 0;
    if (key_a >> 3 * left_a != 1 || key_b >> 3 * left_b != 1) return false;

    WalkEntry e{0, 0, {plan.d[0], plan.d[1], plan.d[2]}, 0, 0, 0, plain_cell, plain_cell};
    for (int i = 0; i < plan.count; ++i) {
        const WalkStep& step = plan.steps[i];
        const bool open_a = step.scale_a != 0, open_b = step.scale_b != 0;
        const unsigned oa = open_a ? digit(key_a, --left_a) : 0, ob = open_b ? digit(key_b, --left_b) : 0;
        const std::uint32_t state_a = open_a ? visit(plan.nodes_a[e.a], plan.stamp) : 0;
        const std::uint32_t state_b = open_b ? visit(plan.nodes_b[e.b], plan.stamp) : 0;
        if (open_a && (!(state_a & OcstNode::expanded_bit) || !(state_a >> oa & 1))) return false;
        if (open_b && (!(state_b & OcstNode::expanded_bit) || !(state_b >> ob & 1))) return false;
        const float x = e.d[0] + plan.bx[ob] * step.scale_b - plan.ax[oa] * step.scale_a;
        const float y = e.d[1] + plan.by[ob] * step.scale_b - plan.ay[oa] * step.scale_a;
        const float z = e.d[2] + plan.bz[ob] * step.scale_b - plan.az[oa] * step.scale_a;
        if constexpr (tight) {
            Opened opened;
            open_tight(plan, e, step, opened);
            const unsigned grey = open_a ? state_a & 0xff : state_b & 0xff;
            const F32x8 gap =
                gap_between(opened.lanes, spread(opened.others, open_a ? ob : 0), plan.reach, lanes_of(grey));
            if (!(gap[open_a ? oa : ob] <= plan.reach)) return false;
            if (open_a) e.tight_a = cell_of(plan.tight_a[e.a], oa);
            if (open_b) e.tight_b = cell_of(plan.tight_b[e.b], ob);
        } else if (!(x * x + y * y + z * z <= step.reach2)) {
            return false;
        }
        if (left_a && open_a) e.a = child(plan.nodes_a[e.a], state_a & 0xff, oa);
        if (left_b && open_b) e.b = child(plan.nodes_b[e.b], state_b & 0xff, ob);
        e.d[0] = x, e.d[1] = y, e.d[2] = z;
    }
    return true;
}

WalkEnd walk_either(const WalkPlan& plan, WalkState& state)
{
    return plan.tight_a ? walk<true>(plan, state) : walk<false>(plan, state);
}

bool replay_either(const WalkPlan& plan, CellKey a, CellKey b)
{
    return plan.tight_a ? replay<true>(plan, a, b) : replay<false>(plan, a, b);
}

} // namespace

WalkKernel walk_kernel()
{
    return {walk_either, replay_either};
}

} // namespace oncollide::ONCOLLIDE_ISA
