// Eight vectors, and eight integers as floats, for kernel files only; like simd.hpp, all code here is in the kernel's
// own namespace.
#include <oncollide/base/simd/simd.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

inline F32x8 widen(const std::int16_t (&from)[8])
{
#if defined(__AVX2__) // GCC would otherwise widen halves and join them
    const __m128i v = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
    return reinterpret_cast<F32x8>(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(v)));
#else
    std::int16_t v __attribute__((vector_size(16)));
    __builtin_memcpy(&v, from, sizeof v);
    return __builtin_convertvector(__builtin_convertvector(v, I32x8), F32x8);
#endif
}
inline F32x8 widen(const std::uint16_t (&from)[8])
{
#if defined(__AVX2__)
    const __m128i v = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
    return reinterpret_cast<F32x8>(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(v)));
#else
    std::uint16_t v __attribute__((vector_size(16)));
    __builtin_memcpy(&v, from, sizeof v);
    return __builtin_convertvector(__builtin_convertvector(v, I32x8), F32x8);
#endif
}

struct Vec {
    F32x8 x, y, z;
};
inline Vec load(const float (&from)[3][8])
{
    return {load(from[0]), load(from[1]), load(from[2])};
}
inline F32x8 dot(const Vec& a, const Vec& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec scaled(const Vec& v, F32x8 by)
{
    return {v.x * by, v.y * by, v.z * by};
}
inline Vec choose(I32x8 which, const Vec& a, const Vec& b)
{
    return {which ? a.x : b.x, which ? a.y : b.y, which ? a.z : b.z};
}
inline Vec cross(const Vec& a, const Vec& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

} // namespace
} // namespace oncollide::ONCOLLIDE_ISA
