// Pairs of triangles, one per lane, for kernel files only (see oncollide_add_kernel): everything here is in the
// kernel's own namespace, so that code compiled for AVX never replaces the baseline's.
//
// When a sign is certain: let X, Y, Z be the sides of the pair's common box, each plus 2^-300. A determinant has six
// terms, each the product of a difference in x, one in y and one in z, so with u = 2^-53 the bound of
// exact_predicates.hpp, 8 u (1 + 8 u) P, has P <= 6 X Y Z; with the rounding of the sides and of their product, 56 u X
// Y Z bounds the error. A product of two differences that underflows, times the third side, errs by at most 2^-1072 X,
// and likewise for Y and Z: the 2^-300 in the other sides covers that. Sides above 2^300 might overflow; the bound is
// then infinite.
#include <oncollide/base/simd/simd_doubles.hpp>
#include <oncollide/narrowphase/exact/kernels/triangle_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

#if defined(__AVX512F__)
using F64 = F64x8;
using I64 = I64x8;
#elif defined(__AVX2__)
using F64 = F64x4;
using I64 = I64x4;
#else
using F64 = F64x2;
using I64 = I64x2;
#endif
constexpr int width = sizeof(F64) / sizeof(double);

struct Vec {
    F64 x, y, z;
};
inline Vec operator-(const Vec& a, const Vec& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec min(const Vec& a, const Vec& b)
{
    return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
inline Vec max(const Vec& a, const Vec& b)
{
    return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
}
inline F64 select(I64 mask, F64 a, F64 b)
{
    return mask ? a : b;
}
inline Vec select(I64 mask, const Vec& a, const Vec& b)
{
    return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
inline Vec cross(const Vec& u, const Vec& v)
{
    return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
inline F64 dot(const Vec& u, const Vec& v)
{
    return u.x * v.x + u.y * v.y + u.z * v.z;
}

struct Corners {
    Vec p, q, r;
};

/// Sides of the box around both, slightly enlarged.
inline Vec sides(const Corners& a, const Corners& b)
{
    const Vec lo = min(min(min(a.p, a.q), a.r), min(min(b.p, b.q), b.r));
    const Vec hi = max(max(max(a.p, a.q), a.r), max(max(b.p, b.q), b.r));
    const Vec side = hi - lo;
    return {side.x + 0x1p-300, side.y + 0x1p-300, side.z + 0x1p-300};
}

inline F64 error_bound(const Corners& a, const Corners& b)
{
    const auto [x, y, z] = sides(a, b);
    const F64 bound = x * y * z * (56 * 0x1p-53);
    return max(max(x, y), z) < 0x1p300 ? bound : F64{} + __builtin_inf();
}

/// Sides of a plane on which a triangle's corners are: lanes in which p, q, r are certainly above, or below.
struct Sides {
    F64 p, q, r; ///< heights above the plane, times the normal's length
    I64 p_above, q_above, r_above, p_below, q_below, r_below;
    Vec normal;

    [[gnu::always_inline]] Sides(const Corners& corners, const Corners& plane, F64 bound)
    {
        normal = cross(plane.q - plane.p, plane.r - plane.p);
        p = dot(normal, corners.p - plane.p), q = dot(normal, corners.q - plane.p),
        r = dot(normal, corners.r - plane.p);
        p_above = p > bound, q_above = q > bound, r_above = r > bound;
        p_below = p < -bound, q_below = q < -bound, r_below = r < -bound;
    }
    I64 apart() const { return (p_above & q_above & r_above) | (p_below & q_below & r_below); }
    I64 known() const { return (p_above | p_below) & (q_above | q_below) & (r_above | r_below); }
    /// The least height, if all corners are on one side.
    F64 beyond() const { return max(min(min(p, q), r), -max(max(p, q), r)); }
};

/// Moves the corner that is alone on its side to the first position, in lanes whose sides are known.
struct Turn {
    I64 r_alone, q_alone;
    I64 above; ///< true if that corner is above

    explicit Turn(const Sides& s)
        : r_alone(~(s.p_above ^ s.q_above)), q_alone(~(s.p_above ^ s.r_above) & ~r_alone),
          above((r_alone & s.r_above) | (q_alone & s.q_above) | (~(r_alone | q_alone) & s.p_above))
    {
    }
    template <class Of>
    void operator()(Of& p, Of& q, Of& r) const
    {
        const Of old_p = p, old_q = q, old_r = r;
        p = select(r_alone, old_r, select(q_alone, old_q, old_p));
        q = select(r_alone, old_p, select(q_alone, old_r, old_q));
        r = select(r_alone, old_q, select(q_alone, old_p, old_r));
    }
};

/// Lane i gets the three numbers at v[i].
#if defined(__AVX2__)
inline void gather4(const double* const* v, __m256d (&xyz)[3])
{
    const __m256i three = _mm256_setr_epi64x(-1, -1, -1, 0);
    const __m256d p0 = _mm256_maskload_pd(v[0], three), p1 = _mm256_maskload_pd(v[1], three),
                  p2 = _mm256_maskload_pd(v[2], three), p3 = _mm256_maskload_pd(v[3], three);
    const __m256d xz01 = _mm256_unpacklo_pd(p0, p1), xz23 = _mm256_unpacklo_pd(p2, p3);
    const __m256d y01 = _mm256_unpackhi_pd(p0, p1), y23 = _mm256_unpackhi_pd(p2, p3);
    xyz[0] = _mm256_permute2f128_pd(xz01, xz23, 0x20), xyz[1] = _mm256_permute2f128_pd(y01, y23, 0x20);
    xyz[2] = _mm256_permute2f128_pd(xz01, xz23, 0x31);
}
#endif
inline Vec gather(const double* const* v)
{
#if defined(__AVX512F__)
    __m256d low[3], high[3];
    gather4(v, low), gather4(v + 4, high);
    const auto join = [&](int k) -> F64 { return __builtin_shufflevector(low[k], high[k], 0, 1, 2, 3, 4, 5, 6, 7); };
    return {join(0), join(1), join(2)};
#elif defined(__AVX2__)
    __m256d all[3];
    gather4(v, all);
    return {all[0], all[1], all[2]};
#else
    return {F64{v[0][0], v[1][0]}, F64{v[0][1], v[1][1]}, F64{v[0][2], v[1][2]}};
#endif
}

/// Moves a point as RelativePose does, operation by operation.
inline Vec moved(const Vec& p, const double* rotation, const double* translation)
{
    const auto row = [&](int i) {
        return rotation[i] * p.x + (rotation[3 + i] * p.y + rotation[6 + i] * p.z) + translation[i];
    };
    return {row(0), row(1), row(2)};
}

struct TwoCorners {
    Corners a, b;
};
/// The corners of the pairs from `first` on; B's are moved.
inline TwoCorners corners_of(const CornersOfPairs& of, unsigned first, const double* rotation,
                             const double* translation)
{
    return {{gather(of.a[0] + first), gather(of.a[1] + first), gather(of.a[2] + first)},
            {moved(gather(of.b[0] + first), rotation, translation),
             moved(gather(of.b[1] + first), rotation, translation),
             moved(gather(of.b[2] + first), rotation, translation)}};
}

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
