// Eight float lanes, for kernel files only (see oncollide_add_kernel): everything here is in the kernel's own
// namespace, so that code compiled for AVX never stands in for the baseline's.
#include <cstdint>
#include <immintrin.h>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

using F32x8 = float __attribute__((vector_size(32), aligned(32)));
using F32x8u = float __attribute__((vector_size(32), aligned(4)));
using I32x8 = std::int32_t __attribute__((vector_size(32)));

inline F32x8 load(const float* p)
{
    return *reinterpret_cast<const F32x8u*>(p);
}
inline void store(float* p, F32x8 v)
{
    *reinterpret_cast<F32x8u*>(p) = v;
}
inline F32x8 splat(float x)
{
    return F32x8{x, x, x, x, x, x, x, x};
}
// Of equal numbers, and where one is none, the second: as the instructions do it, so on every instruction set.
#if defined(__AVX2__)
inline F32x8 min(F32x8 a, F32x8 b)
{
    return reinterpret_cast<F32x8>(_mm256_min_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
}
inline F32x8 max(F32x8 a, F32x8 b)
{
    return reinterpret_cast<F32x8>(_mm256_max_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
}
#else
inline F32x8 min(F32x8 a, F32x8 b)
{
    return a < b ? a : b;
}
inline F32x8 max(F32x8 a, F32x8 b)
{
    return a > b ? a : b;
}
#endif

inline F32x8 sqrt(F32x8 v)
{
#if defined(__AVX2__)
    return reinterpret_cast<F32x8>(_mm256_sqrt_ps(reinterpret_cast<__m256>(v)));
#else
    union {
        F32x8 whole;
        __m128 half[2];
    } u{v};
    u.half[0] = _mm_sqrt_ps(u.half[0]), u.half[1] = _mm_sqrt_ps(u.half[1]);
    return u.whole;
#endif
}

/// One bit a lane of a comparison's result.
inline unsigned bits(I32x8 mask)
{
#if defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
    union {
        I32x8 whole;
        __m128 half[2];
    } u{mask};
    return static_cast<unsigned>(_mm_movemask_ps(u.half[0]) | _mm_movemask_ps(u.half[1]) << 4);
#endif
}

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
