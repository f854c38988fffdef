// Emscripten's header, with numbers in all lanes as splat.h has them.
#include_next <xmmintrin.h>
#include "splat.h"
