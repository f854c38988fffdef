// Emscripten expresses SSE2 but has no such header for MMX, which Eigen includes and does not use.
#pragma once
