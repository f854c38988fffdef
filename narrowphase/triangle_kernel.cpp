// Compiled once per instruction set; see oncollide_add_kernel.
//
// Guigue and Devillers' test for triangle_contact's generic case, a lane a pair. A sign counts only where the filter of
// exact_predicates.hpp certifies it; the bound is the same, term by term. A pair with an uncertain sign is left to the
// scalar test unless another sign shows that it is separate.
#include <oncollide/broadphase/simd.hpp>
#include <oncollide/narrowphase/triangle_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
using F64 = double __attribute__((vector_size(8 * width)));
using I64 = long long __attribute__((vector_size(8 * width)));

constexpr double bound_factor = 9 * 0x1p-53, tiny = 0x1p-900; // filter_bound_3d, filter_tiny

inline F64 splat(double x)
{
    return F64{} + x;
}
inline F64 abs(F64 x)
{
    return reinterpret_cast<F64>(reinterpret_cast<I64>(x) & 0x7fffffffffffffff);
}
/// One bit a lane.
inline unsigned bits(I64 mask)
{
#if defined(__AVX512F__)
    return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
    return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(mask)));
#endif
}

struct Vec {
    F64 x, y, z;
};
inline Vec operator-(Vec a, Vec b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec select(I64 mask, Vec a, Vec b)
{
    return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}

/// Lanes in which a determinant is certainly positive, and certainly negative.
struct Sign {
    I64 above, below;

    I64 known() const { return above | below; }
};

/// u x v, and the same with magnitudes.
struct Cross {
    Vec value, magnitude;

    Cross(Vec u, Vec v)
    {
        const auto set = [](F64 left, F64 right, F64& difference, F64& sum) {
            difference = left - right, sum = abs(left) + abs(right) + tiny;
        };
        set(u.y * v.z, u.z * v.y, value.x, magnitude.x);
        set(u.z * v.x, u.x * v.z, value.y, magnitude.y);
        set(u.x * v.y, u.y * v.x, value.z, magnitude.z);
    }
    Sign side(Vec w) const
    {
        const F64 x = value.x * w.x + value.y * w.y + value.z * w.z;
        const F64 bound =
            bound_factor * (magnitude.x * abs(w.x) + magnitude.y * abs(w.y) + magnitude.z * abs(w.z)) + tiny;
        return {x > bound, x < -bound};
    }
};

/// A lane's triangle, or the same one in all lanes.
struct Corners {
    Vec corner[3];
};

inline Corners same_in_all(const double* c)
{
    Corners t;
    for (int k = 0; k < 3; ++k) t.corner[k] = {splat(c[3 * k]), splat(c[3 * k + 1]), splat(c[3 * k + 2])};
    return t;
}

/// The lone corner and the two edges that leave it, in cyclic order.
struct Wedge {
    Vec apex, first, second;
    I64 above; ///< is the apex above the other's plane?
};

inline Wedge wedge_of(const Corners& t, const Sign sides[3])
{
    const I64 a = sides[0].above, b = sides[1].above, c = sides[2].above;
    const I64 two = ~(a ^ b), one = ~two & ~(a ^ c); // else corner 0 is alone
    const Vec e0 = t.corner[1] - t.corner[0], e1 = t.corner[2] - t.corner[1], e2 = t.corner[0] - t.corner[2];
    const Vec b0 = t.corner[2] - t.corner[0], b1 = t.corner[0] - t.corner[1], b2 = t.corner[1] - t.corner[2];
    const auto pick = [&](Vec at_0, Vec at_1, Vec at_2) { return select(two, at_2, select(one, at_1, at_0)); };
    return {pick(t.corner[0], t.corner[1], t.corner[2]), pick(e0, e1, e2), pick(b0, b1, b2),
            (two & c) | (one & b) | (~(two | one) & a)};
}

struct Verdicts {
    I64 separate, known;
};

/// `normal` is the query's.
inline Verdicts judge(const Corners& query, const Cross& normal, const Corners& other)
{
    Sign of_other[3], of_query[3];
    for (int k = 0; k < 3; ++k) of_other[k] = normal.side(other.corner[k] - query.corner[0]);
    I64 separate = (of_other[0].above & of_other[1].above & of_other[2].above) |
                   (of_other[0].below & of_other[1].below & of_other[2].below);
    if (bits(~separate) == 0) return {separate, separate};

    const Cross other_normal(other.corner[1] - other.corner[0], other.corner[2] - other.corner[0]);
    for (int k = 0; k < 3; ++k) of_query[k] = other_normal.side(query.corner[k] - other.corner[0]);
    separate |= (of_query[0].above & of_query[1].above & of_query[2].above) |
                (of_query[0].below & of_query[1].below & of_query[2].below);
    if (bits(~separate) == 0) return {separate, separate};
    I64 known = ~separate;
    for (int k = 0; k < 3; ++k) known &= of_other[k].known() & of_query[k].known();

    // As in triangle_contact: q and r beside p are the query's, t and u beside s the other's.
    const Wedge a = wedge_of(query, of_query), b = wedge_of(other, of_other);
    const I64 alike = ~(a.above ^ b.above);
    const Vec w = b.apex - a.apex;
    const Sign first = Cross(a.first, select(alike, b.first, b.second)).side(w);
    const Sign second = Cross(a.second, select(alike, b.second, b.first)).side(w);
    const I64 wrong_first = b.above ? first.below : first.above, wrong_second = b.above ? second.above : second.below;
    separate |= known & (wrong_first | wrong_second);
    return {separate, separate | (known & first.known() & second.known())};
}

/// Up to eight triangles whose boxes overlap the query's, by coordinate.
struct Batch {
    alignas(64) double at[9][8];
    std::uint32_t number[8];
    int count = 0;

    void add(std::uint32_t i, const double* corners)
    {
        for (int k = 0; k < 9; ++k) at[k][count] = corners[9 * std::size_t(i) + k];
        number[count++] = i;
    }
};

std::uint32_t meeting(const TriangleQuery& query, const BoxBlock* blocks, const double* corners, std::uint32_t begin,
                      std::uint32_t end, bool first_only, std::uint32_t* out)
{
    const Corners mine = same_in_all(query.corners);
    const Cross normal(mine.corner[1] - mine.corner[0], mine.corner[2] - mine.corner[0]);
    std::uint32_t found = 0;
    bool sure = false;
    Batch batch;
    for (auto& row : batch.at)
        for (double& x : row) x = 0;

    const auto flush = [&] {
        for (int first = 0; first < batch.count; first += width) {
            Corners other;
            for (int k = 0; k < 3; ++k) {
                const auto row = [&](int axis) {
                    return *reinterpret_cast<const F64*>(&batch.at[3 * k + axis][first]);
                };
                other.corner[k] = {row(0), row(1), row(2)};
            }
            const Verdicts verdicts = judge(mine, normal, other);
            const unsigned known = bits(verdicts.known);
            const int left = batch.count - first;
            unsigned rest = bits(~verdicts.separate) & (left < width ? (1u << left) - 1 : ~0u);
            for (; rest; rest &= rest - 1) {
                const int lane = __builtin_ctz(rest);
                const unsigned unknown = ~known >> lane & 1;
                out[found++] = batch.number[first + lane] << 1 | unknown;
                sure |= !unknown;
            }
        }
        batch.count = 0;
    };

    for (std::uint32_t block = begin; block < end && !(first_only && sure); ++block) {
        I32x8 overlap = I32x8{} == 0;
        for (int axis = 0; axis < 3; ++axis)
            overlap &= (load(blocks[block].lo[axis]) <= splat(query.hi[axis])) &
                       (load(blocks[block].hi[axis]) >= splat(query.lo[axis]));
        for (unsigned mask = bits(overlap); mask; mask &= mask - 1) {
            batch.add(8 * block + static_cast<unsigned>(__builtin_ctz(mask)), corners);
            if (batch.count == 8) flush();
        }
    }
    flush();
    return found;
}

} // namespace

MeetingTriangles* meeting_triangles()
{
    return meeting;
}

} // namespace oncollide::ONCOLLIDE_ISA
