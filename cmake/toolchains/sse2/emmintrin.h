// Emscripten's header, with numbers in all lanes as splat.h has them.
#include_next <emmintrin.h>

#pragma once
static __inline__ __m128d __attribute__((__always_inline__, __nodebug__)) oncollide_set1_pd(double number)
{
    __asm("" : "+r"(number));
    return __extension__(__m128d){number, number};
}
#undef _mm_set1_pd
#undef _mm_set_pd1
#define _mm_set1_pd oncollide_set1_pd
#define _mm_set_pd1 oncollide_set1_pd
