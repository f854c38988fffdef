// Pairs of triangles, a lane each, in double, for kernel files only, as simd.hpp is.
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <oncollide/narrowphase/exact/triangle_kernel.hpp>

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

#if defined(__AVX512F__)
inline F64 min(F64 a, F64 b)
{
    return _mm512_maskz_min_pd(0xff, a, b);
}
inline F64 max(F64 a, F64 b)
{
    return _mm512_maskz_max_pd(0xff, a, b);
}
/// One bit a lane.
inline unsigned bits(I64 mask)
{
    return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
}
#elif defined(__AVX2__)
inline F64 min(F64 a, F64 b)
{
    return _mm256_min_pd(a, b);
}
inline F64 max(F64 a, F64 b)
{
    return _mm256_max_pd(a, b);
}
inline unsigned bits(I64 mask)
{
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
}
#elif defined(__SSE2__)
inline F64 min(F64 a, F64 b)
{
    return _mm_min_pd(a, b);
}
inline F64 max(F64 a, F64 b)
{
    return _mm_max_pd(a, b);
}
inline unsigned bits(I64 mask)
{
    return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(mask)));
}
#else
inline F64 min(F64 a, F64 b)
{
    return a < b ? a : b;
}
inline F64 max(F64 a, F64 b)
{
    return a > b ? a : b;
}
inline unsigned bits(I64 mask)
{
    return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2));
}
#endif

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

/// Lane i holds v[i][k].
inline F64 gather(const double* const* v, int k)
{
#if defined(__AVX512F__)
    return F64{v[0][k], v[1][k], v[2][k], v[3][k], v[4][k], v[5][k], v[6][k], v[7][k]};
#elif defined(__AVX2__)
    return F64{v[0][k], v[1][k], v[2][k], v[3][k]};
#else
    return F64{v[0][k], v[1][k]};
#endif
}

inline Vec gather(const double* const* v)
{
    return {gather(v, 0), gather(v, 1), gather(v, 2)};
}

/// As RelativePose does, operation by operation.
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
/// Of the pairs from `first` on, those of B moved.
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
