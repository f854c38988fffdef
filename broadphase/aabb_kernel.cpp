// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

/// The largest lane, in every lane.
inline F32x8 greatest(F32x8 v)
{
    v = max(v, ONCOLLIDE_SHUFFLE(v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = max(v, ONCOLLIDE_SHUFFLE(v, 2, 3, 0, 1, 6, 7, 4, 5));
    return max(v, ONCOLLIDE_SHUFFLE(v, 1, 0, 3, 2, 5, 4, 7, 6));
}

std::uint32_t overlap_range(const AabbColumnsView& c, std::uint32_t begin, std::uint32_t end, const float box[6],
                            std::uint32_t* out)
{
    const F32x8 lo_x = splat(box[0]), lo_y = splat(box[1]), lo_z = splat(box[2]);
    const F32x8 hi_x = splat(box[3]), hi_y = splat(box[4]), hi_z = splat(box[5]);
    std::uint32_t found = 0;
    for (std::uint32_t i = begin; i < end; i += 8) {
        unsigned overlap = bits((load(c.lo[0] + i) <= hi_x) & (load(c.hi[0] + i) >= lo_x) & //
                                (load(c.lo[1] + i) <= hi_y) & (load(c.hi[1] + i) >= lo_y) & //
                                (load(c.lo[2] + i) <= hi_z) & (load(c.hi[2] + i) >= lo_z));
        if (end - i < 8) overlap &= (1u << (end - i)) - 1;
        for (; overlap; overlap &= overlap - 1) out[found++] = i + static_cast<std::uint32_t>(__builtin_ctz(overlap));
    }
    return found;
}

void support_box(const float* x, const float* y, const float* z, std::uint32_t count, const float rows[9], float lo[3],
                 float hi[3])
{
    F32x8 low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) low[axis] = splat(__builtin_inff()), high[axis] = splat(-__builtin_inff());
    for (std::uint32_t i = 0; i < count; i += 8) {
        const F32x8 px = load(x + i), py = load(y + i), pz = load(z + i);
        for (int axis = 0; axis < 3; ++axis) {
            const F32x8 v = rows[3 * axis] * px + rows[3 * axis + 1] * py + rows[3 * axis + 2] * pz;
            low[axis] = min(low[axis], v), high[axis] = max(high[axis], v);
        }
    }
    for (int axis = 0; axis < 3; ++axis) lo[axis] = -greatest(-low[axis])[0], hi[axis] = greatest(high[axis])[0];
}

void lists_box(const float* x, const float* y, const float* z, const PointRange lists[6], const float rows[9],
               float lo[3], float hi[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const float *const d = rows + 3 * axis, infinite = __builtin_inff();
        const auto along = [=](std::uint32_t i) {
            return d[0] * load(x + i) + d[1] * load(y + i) + d[2] * load(z + i);
        };
        const PointRange high = lists[2 * axis], low = lists[2 * axis + 1];
        F32x8 most = splat(-infinite), least = splat(infinite);
        for (std::uint32_t i = high.begin; i < high.begin + high.count; i += 8) most = max(most, along(i));
        for (std::uint32_t i = low.begin; i < low.begin + low.count; i += 8) least = min(least, along(i));
        lo[axis] = -greatest(-least)[0], hi[axis] = greatest(most)[0];
    }
}

float most_along(const float* x, const float* y, const float* z, std::uint32_t count, const float d[3])
{
    F32x8 high = splat(-__builtin_inff());
    for (std::uint32_t i = 0; i < count; i += 8)
        high = max(high, d[0] * load(x + i) + d[1] * load(y + i) + d[2] * load(z + i));
    return greatest(high)[0];
}

/// Among points with equal projections, returns the first of the first lane.
std::uint32_t farthest(const float* x, const float* y, const float* z, std::uint32_t count, const float d[3])
{
    F32x8 high = splat(-__builtin_inff());
    I32x8 at{};
    for (std::uint32_t i = 0; i < count; i += 8) {
        const F32x8 along = d[0] * load(x + i) + d[1] * load(y + i) + d[2] * load(z + i);
        const I32x8 farther = along > high;
        at = farther ? I32x8{} + static_cast<std::int32_t>(i) : at;
        high = max(along, high);
    }
    const auto lane = static_cast<std::uint32_t>(__builtin_ctz(bits(high == greatest(high))));
    std::int32_t place[8];
    __builtin_memcpy(place, &at, sizeof place);
    return static_cast<std::uint32_t>(place[lane]) + lane;
}

void keep_farthest(const float* x, const float* y, const float* z, std::uint32_t count, const float (&directions)[4][3],
                   float rounding, float* along, std::int32_t* keep)
{
    const std::uint32_t room = (count + 7) / 8 * 8;
    F32x8 most[5];
    for (F32x8& of_all : most) of_all = splat(-__builtin_inff());
    I32x8 at[5] = {};
    for (std::uint32_t i = 0; i < room; i += 8) {
        const F32x8 px = load(x + i), py = load(y + i), pz = load(z + i);
        F32x8 sum{};
#pragma GCC unroll 5
        for (std::uint32_t k = 0; k < 5; ++k) {
            const F32x8 v =
                k < 4 ? directions[k & 3][0] * px + directions[k & 3][1] * py + directions[k & 3][2] * pz : sum;
            sum += v;
            store(along + k * room + i, v);
            const I32x8 farther = v > most[k];
            at[k] = farther ? I32x8{} + static_cast<std::int32_t>(i) : at[k];
            most[k] = max(v, most[k]);
        }
    }
    float bar[5][4]; // the other points' projections onto each direction, less rounding
    for (std::uint32_t k = 0; k < 5; ++k) {
        const int lane = __builtin_ctz(bits(most[k] == greatest(most[k])));
        const std::uint32_t other = static_cast<std::uint32_t>(at[k][lane] + lane);
        for (std::uint32_t c = 0; c < 4; ++c) bar[k][c] = along[c * room + other] - rounding;
    }
    for (std::uint32_t i = 0; i < room; i += 8) {
        const F32x8 a0 = load(along + i), a1 = load(along + room + i), a2 = load(along + 2 * room + i),
                    a3 = load(along + 3 * room + i);
        I32x8 every = I32x8{} + 1;
        for (const auto& b : bar) every &= (a0 >= b[0]) | (a1 >= b[1]) | (a2 >= b[2]) | (a3 >= b[3]);
        __builtin_memcpy(keep + i, &every, sizeof every);
    }
}

} // namespace

AabbKernel aabb_kernel()
{
    return {overlap_range, support_box, lists_box, most_along, farthest, keep_farthest};
}

} // namespace oncollide::ONCOLLIDE_ISA
