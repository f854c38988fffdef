// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/base/simd/simd_doubles.hpp>
#include <oncollide/scenes/model/vertex_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

constexpr std::size_t in_group = 4; // vertices: three vectors of four coordinates

struct Group {
    F64x4 a, b, c;
};
inline F64x4 four_at(const double* from)
{
    using Anywhere = double __attribute__((vector_size(32), aligned(8), may_alias));
    return *reinterpret_cast<const Anywhere*>(from);
}
inline Group group_at(const double* from)
{
    return {four_at(from), four_at(from + 4), four_at(from + 8)};
}
/// Up to four vertices, of which the last one is repeated.
inline Group last_group(const double* from, std::size_t count)
{
    double padded[3 * in_group];
    for (std::size_t v = 0; v < in_group; ++v)
        for (std::size_t i = 0; i < 3; ++i) padded[3 * v + i] = from[3 * (v < count ? v : count - 1) + i];
    return group_at(padded);
}

/// The bounds of one of the vectors of a group, over all groups.
struct Column {
    F64x4 low, high, moved, odd; // odd: 0, or not a number

    void add(F64x4 now, F64x4 before)
    {
        const F64x4 by = now - before;
        low = min(low, now), high = max(high, now), moved = max(moved, max(by, -by)), odd += now * 0.0;
    }
};
struct Columns {
    Column a, b, c;

    void add(const Group& now, const Group& before)
    {
        a.add(now.a, before.a), b.add(now.b, before.b), c.add(now.c, before.c);
    }
};

void extent(const double* vertices, const double* before, std::size_t count, VertexExtent& out)
{
    const double end = __builtin_inf();
    const F64x4 least{end, end, end, end};
    const Column none{least, -least, {}, {}};
    Columns columns{none, none, none};
    std::size_t v = 0;
    for (; v + in_group <= count; v += in_group) columns.add(group_at(vertices + 3 * v), group_at(before + 3 * v));
    if (v < count) columns.add(last_group(vertices + 3 * v, count - v), last_group(before + 3 * v, count - v));
    out.finite = true;
    for (int i = 0; i < 3; ++i) out.low[i] = end, out.high[i] = -end, out.moved[i] = 0;
    const Column* const parts[3] = {&columns.a, &columns.b, &columns.c};
    for (int i = 0; i < 12; ++i) {
        const Column& part = *parts[i / 4];
        const int axis = i % 3, lane = i % 4;
        out.low[axis] = part.low[lane] < out.low[axis] ? part.low[lane] : out.low[axis];
        out.high[axis] = part.high[lane] > out.high[axis] ? part.high[lane] : out.high[axis];
        out.moved[axis] = part.moved[lane] > out.moved[axis] ? part.moved[lane] : out.moved[axis];
        out.finite &= part.odd[lane] == 0;
    }
}

/// The squared lengths of four vertices.
inline F64x4 squares(const Group& at)
{
    const F64x4 a = at.a * at.a, b = at.b * at.b, c = at.c * at.c;
    const F64x4 x = __builtin_shufflevector(a, b, 0, 3, 6, 6), y = __builtin_shufflevector(a, b, 1, 4, 7, 7),
                z = __builtin_shufflevector(a, b, 2, 5, 5, 5);
    return (__builtin_shufflevector(x, c, 0, 1, 2, 5) + __builtin_shufflevector(y, c, 0, 1, 2, 6)) +
           __builtin_shufflevector(z, c, 0, 1, 4, 7);
}

double radius2(const double* vertices, std::size_t count, const double (&centre)[3])
{
    const double x = centre[0], y = centre[1], z = centre[2];
    const Group middle{{x, y, z, x}, {y, z, x, y}, {z, x, y, z}};
    F64x4 most{};
    const auto add = [&](const Group& at) {
        most = max(most, squares({at.a - middle.a, at.b - middle.b, at.c - middle.c}));
    };
    std::size_t v = 0;
    for (; v + in_group <= count; v += in_group) add(group_at(vertices + 3 * v));
    if (v < count) add(last_group(vertices + 3 * v, count - v));
    double greatest = 0;
    for (int lane = 0; lane < 4; ++lane) greatest = most[lane] > greatest ? most[lane] : greatest;
    return greatest;
}

} // namespace

VertexKernel vertex_kernel()
{
    return {extent, radius2};
}

} // namespace oncollide::ONCOLLIDE_ISA
