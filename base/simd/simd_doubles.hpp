// Two, four or eight lanes of doubles, for kernel files only; like simd.hpp, all code here is in the kernel's own
// namespace.
// Eight lanes exist with AVX-512 only.
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace oncollide::ONCOLLIDE_ISA {
namespace {

using F64x2 = double __attribute__((vector_size(16)));
using I64x2 = long long __attribute__((vector_size(16)));
using F64x4 = double __attribute__((vector_size(32)));
using I64x4 = long long __attribute__((vector_size(32)));

// min, max: return b if the operands are equal or one is NaN, as the x86 instructions do, so results match on all
// instruction sets. bits(): one bit per lane of a comparison's result.
#if defined(__SSE2__)
inline F64x2 min(F64x2 a, F64x2 b)
{
    return _mm_min_pd(a, b);
}
inline F64x2 max(F64x2 a, F64x2 b)
{
    return _mm_max_pd(a, b);
}
inline F64x2 sqrt(F64x2 v)
{
    return _mm_sqrt_pd(v);
}
inline unsigned bits(I64x2 mask)
{
    return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(mask)));
}
#else
inline F64x2 min(F64x2 a, F64x2 b)
{
    return a < b ? a : b;
}
inline F64x2 max(F64x2 a, F64x2 b)
{
    return a > b ? a : b;
}
inline F64x2 sqrt(F64x2 v)
{
    return F64x2{__builtin_sqrt(v[0]), __builtin_sqrt(v[1])};
}
inline unsigned bits(I64x2 mask)
{
    return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2));
}
#endif

#if defined(__AVX2__)
inline F64x4 min(F64x4 a, F64x4 b)
{
    return _mm256_min_pd(a, b);
}
inline F64x4 max(F64x4 a, F64x4 b)
{
    return _mm256_max_pd(a, b);
}
inline F64x4 sqrt(F64x4 v)
{
    return _mm256_sqrt_pd(v);
}
inline unsigned bits(I64x4 mask)
{
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
}
#else
inline F64x4 min(F64x4 a, F64x4 b)
{
    return a < b ? a : b;
}
inline F64x4 max(F64x4 a, F64x4 b)
{
    return a > b ? a : b;
}
inline F64x4 sqrt(F64x4 v)
{
    return F64x4{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]), __builtin_sqrt(v[3])};
}
inline unsigned bits(I64x4 mask)
{
    return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
}
#endif

/// The lanes of four in the given order.
#if defined(__clang__) || (defined(__has_builtin) && __has_builtin(__builtin_shufflevector))
#define ONCOLLIDE_SHUFFLE_DOUBLES(v, ...) __builtin_shufflevector(v, v, __VA_ARGS__)
#else // GCC before 12
#define ONCOLLIDE_SHUFFLE_DOUBLES(v, ...) __builtin_shuffle(v, I64x4{__VA_ARGS__})
#endif

inline F64x2 abs(F64x2 v)
{
    return max(v, -v);
}
inline F64x4 abs(F64x4 v)
{
    return max(v, -v);
}
/// @param to  aligned to 32 bytes
inline void store(double (&to)[4], F64x4 v)
{
    *reinterpret_cast<F64x4*>(to) = v;
}

#if defined(__AVX512F__)
using F64x8 = double __attribute__((vector_size(64)));
using I64x8 = long long __attribute__((vector_size(64)));

inline F64x8 min(F64x8 a, F64x8 b)
{
    return _mm512_maskz_min_pd(0xff, a, b);
}
inline F64x8 max(F64x8 a, F64x8 b)
{
    return _mm512_maskz_max_pd(0xff, a, b);
}
inline F64x8 abs(F64x8 v)
{
    return max(v, -v);
}
inline F64x8 sqrt(F64x8 v)
{
    return _mm512_maskz_sqrt_pd(0xff, v);
}
inline unsigned bits(I64x8 mask)
{
    return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
}
#endif

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
