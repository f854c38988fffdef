// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/narrowphase/spheres/walk_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// Other threads may traverse the same trees: masks do not change meanwhile, and all threads write the same stamp.
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

/// Sets the lanes of the bits in `grey` to all ones.
inline I32x8 lanes_of(unsigned grey)
{
    const I32x8 lane{1, 2, 4, 8, 16, 32, 64, 128};
    const int g = static_cast<int>(grey);
    return (I32x8{g, g, g, g, g, g, g, g} & lane) != 0;
}

/// Lane k: child k of A against one child of B, or, if A is not descended, A against child k of B.
struct Near {
    F32x8 x, y, z, d2;
    unsigned mask; ///< lanes that touch and are grey
};

inline Near measure(F32x8 x, F32x8 y, F32x8 z, float cutoff2, I32x8 grey, F32x8& nearest2)
{
    Near near{x, y, z, x * x + y * y + z * z, 0};
    const I32x8 touch = near.d2 <= splat(cutoff2);
    near.mask = bits(touch & grey);
    nearest2 = min(nearest2, (grey & ~touch) ? near.d2 : splat(__builtin_inff()));
    return near;
}

/// One function, although it is long: the coordinates of both frames stay in registers.
WalkEnd walk(const WalkPlan& plan, WalkState& s)
{
    const F32x8 ax = load(plan.ax), ay = load(plan.ay), az = load(plan.az);
    const F32x8 bx = load(plan.bx), by = load(plan.by), bz = load(plan.bz);
    F32x8 nearest2[most_steps];
    for (int i = 0; i < plan.count; ++i) nearest2[i] = splat(__builtin_inff());
    const auto end = [&](WalkEnd how) {
        for (int i = 0; i < plan.count; ++i)
            for (int lane = 0; lane < 8; ++lane)
                if (nearest2[i][lane] < s.nearest2[i]) s.nearest2[i] = nearest2[i][lane];
        return how;
    };
    while (s.top) {
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
        const unsigned grey_a = state_a & 0xff, grey_b = state_b & 0xff;
        const I32x8 lanes = lanes_of(open_a ? grey_a : grey_b);
        const std::uint32_t first_pushed = s.top;
        float closest = __builtin_inff();
        std::uint32_t closest_at = first_pushed;

        const auto take = [&](const Near& near, bool lanes_are_a, unsigned other) {
            for (unsigned mask = near.mask; mask; mask &= mask - 1) {
                const auto k = static_cast<unsigned>(__builtin_ctz(mask));
                const unsigned oa = lanes_are_a ? k : other, ob = lanes_are_a ? other : k;
                WalkEntry& out = s.stack[s.top];
                out.key_a = open_a ? below(e.key_a, oa) : e.key_a;
                out.key_b = open_b ? below(e.key_b, ob) : e.key_b;
                if (last) {
                    s.hit_a = out.key_a, s.hit_b = out.key_b;
                    return true;
                }
                out.a = open_a ? child(plan.nodes_a[e.a], grey_a, oa) : e.a;
                out.b = open_b ? child(plan.nodes_b[e.b], grey_b, ob) : e.b;
                out.d[0] = near.x[k], out.d[1] = near.y[k], out.d[2] = near.z[k];
                out.step = e.step + 1;
                if (near.d2[k] < closest) closest = near.d2[k], closest_at = s.top;
                ++s.top;
            }
            return false;
        };

        const F32x8 x = e.d[0] + bx * step.scale_b, y = e.d[1] + by * step.scale_b, z = e.d[2] + bz * step.scale_b;
        if (open_a) {
            const F32x8 oax = ax * step.scale_a, oay = ay * step.scale_a, oaz = az * step.scale_a;
            alignas(32) float child_x[8], child_y[8], child_z[8]; // B's children, to broadcast one at a time
            store(child_x, x), store(child_y, y), store(child_z, z);
            for (unsigned rest = open_b ? grey_b : 1; rest; rest &= rest - 1) {
                const auto j = static_cast<unsigned>(__builtin_ctz(rest));
                if (take(measure(splat(child_x[j]) - oax, splat(child_y[j]) - oay, splat(child_z[j]) - oaz,
                                 step.cutoff2, lanes, nearest2[e.step]),
                         true, j))
                    return WalkEnd::hit;
            }
        } else if (take(measure(x, y, z, step.cutoff2, lanes, nearest2[e.step]), false, 0)) {
            return WalkEnd::hit;
        }
        if (s.top > first_pushed) { // the closest pair is next, as deep contacts end the traversal soonest
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

bool replay(const WalkPlan& plan, CellKey key_a, CellKey key_b)
{
    int left_a = 0, left_b = 0; // levels left to descend on each side
    for (int i = 0; i < plan.count; ++i) left_a += plan.steps[i].scale_a != 0, left_b += plan.steps[i].scale_b != 0;
    if (key_a >> 3 * left_a != 1 || key_b >> 3 * left_b != 1) return false;

    std::uint32_t a = 0, b = 0;
    float x = plan.d[0], y = plan.d[1], z = plan.d[2];
    for (int i = 0; i < plan.count; ++i) {
        const WalkStep& step = plan.steps[i];
        unsigned oa = 0, ob = 0;
        if (step.scale_a != 0) {
            oa = digit(key_a, --left_a);
            const std::uint32_t state = visit(plan.nodes_a[a], plan.stamp);
            if (!(state & OcstNode::expanded_bit) || !(state >> oa & 1)) return false;
            if (left_a) a = child(plan.nodes_a[a], state & 0xff, oa);
        }
        if (step.scale_b != 0) {
            ob = digit(key_b, --left_b);
            const std::uint32_t state = visit(plan.nodes_b[b], plan.stamp);
            if (!(state & OcstNode::expanded_bit) || !(state >> ob & 1)) return false;
            if (left_b) b = child(plan.nodes_b[b], state & 0xff, ob);
        }
        x = x + plan.bx[ob] * step.scale_b, y = y + plan.by[ob] * step.scale_b, z = z + plan.bz[ob] * step.scale_b;
        x = x - plan.ax[oa] * step.scale_a, y = y - plan.ay[oa] * step.scale_a, z = z - plan.az[oa] * step.scale_a;
        if (!(x * x + y * y + z * z <= step.cutoff2)) return false;
    }
    return true;
}

} // namespace

WalkKernel walk_kernel()
{
    return {walk, replay};
}

} // namespace oncollide::ONCOLLIDE_ISA
