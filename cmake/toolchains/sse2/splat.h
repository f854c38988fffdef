// Clang 14 loads a number into all lanes with one instruction (v128.load64_splat), and forgets the order of this load and
// of later stores: `x = pose * x` reads a coordinate of x that it has replaced. Here the number is loaded alone first.
#pragma once

static __inline__ __m128 __attribute__((__always_inline__, __nodebug__)) oncollide_set1_ps(float number)
{
    __asm("" : "+r"(number));
    return __extension__(__m128){number, number, number, number};
}
static __inline__ __m128 __attribute__((__always_inline__, __nodebug__)) oncollide_load_ss(const float* place)
{
    float number = *place;
    __asm("" : "+r"(number));
    return __extension__(__m128){number, 0, 0, 0};
}
#undef _mm_set_ps1
#undef _mm_set1_ps
#undef _mm_load_ss
#define _mm_set_ps1 oncollide_set1_ps
#define _mm_set1_ps oncollide_set1_ps
#define _mm_load_ss oncollide_load_ss
