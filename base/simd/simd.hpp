// Eight float lanes, for kernel files only (see oncollide_add_kernel). All code is in the kernel's own namespace, so
// the linker cannot use functions compiled for AVX in the baseline kernel.
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace oncollide::ONCOLLIDE_ISA {
namespace {

using F32x8 = float __attribute__((vector_size(32), aligned(32)));
using I32x8 = std::int32_t __attribute__((vector_size(32)));

/// For loads and stores at any address: Clang ignores a typedef's lower alignment and assumes the vector type's own.
struct __attribute__((packed, may_alias)) Unaligned {
    float v __attribute__((vector_size(32)));
};
inline F32x8 load(const float* p)
{
    return reinterpret_cast<const Unaligned*>(p)->v;
}
inline void store(float* p, F32x8 v)
{
    reinterpret_cast<Unaligned*>(p)->v = v;
}
inline F32x8 splat(float x)
{
    return F32x8{x, x, x, x, x, x, x, x};
}
// Returns b if the operands are equal or one is NaN, as the x86 instructions do, so results match on all instruction
// sets.
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

inline F32x8 abs(F32x8 v)
{
    return reinterpret_cast<F32x8>(reinterpret_cast<I32x8>(v) & 0x7fffffff);
}

inline F32x8 sqrt(F32x8 v)
{
#if defined(__AVX2__)
    return reinterpret_cast<F32x8>(_mm256_sqrt_ps(reinterpret_cast<__m256>(v)));
#elif defined(__SSE2__)
    union {
        F32x8 whole;
        __m128 half[2];
    } u{v};
    u.half[0] = _mm_sqrt_ps(u.half[0]), u.half[1] = _mm_sqrt_ps(u.half[1]);
    return u.whole;
#else
    for (int lane = 0; lane < 8; ++lane) v[lane] = __builtin_sqrtf(v[lane]);
    return v;
#endif
}

/// The lanes of v in the given order.
#if defined(__clang__) || (defined(__has_builtin) && __has_builtin(__builtin_shufflevector))
#define ONCOLLIDE_SHUFFLE(v, ...) __builtin_shufflevector(v, v, __VA_ARGS__)
#else // GCC before 12
#define ONCOLLIDE_SHUFFLE(v, ...) __builtin_shuffle(v, I32x8{__VA_ARGS__})
#endif

/// One bit per lane of a comparison's result.
inline unsigned bits(I32x8 mask)
{
#if defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#elif defined(__SSE2__)
    union {
        I32x8 whole;
        __m128 half[2];
    } u{mask};
    return static_cast<unsigned>(_mm_movemask_ps(u.half[0]) | _mm_movemask_ps(u.half[1]) << 4);
#else
    const I32x8 v = mask & I32x8{1, 2, 4, 8, 16, 32, 64, 128};
    return static_cast<unsigned>((v[0] | v[1]) | (v[2] | v[3]) | (v[4] | v[5]) | (v[6] | v[7]));
#endif
}

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
