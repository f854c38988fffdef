#pragma once
#include <string>

namespace oncollide::gl {

/// One compute shader per step of a batch; see gl_compute.cpp. 64 invocations per group; each loops over its share.
struct OctantShaders {
    static std::string plan();    ///< rows -> tiles: at most eight triangles of one row each
    static std::string test();    ///< tiles -> masks of rows and triangles, room for lists
    static std::string scatter(); ///< tiles -> entries of lists
    static std::string pack();    ///< live lists -> the same, without holes
    static std::string read();    ///< reads -> triangles, packed
};

/// The binding points of the shaders' buffers.
namespace binding {
constexpr unsigned primitives = 0, entries = 1, lists = 2, rows = 3, cursors = 4, tiles = 5, out = 6;
constexpr unsigned packed = 3, jobs = 4; ///< for pack and read, which use neither rows nor cursors
} // namespace binding

/// Words per item in each buffer.
namespace words {
constexpr unsigned primitive = 12, list = 9, row = 12, cursors = 9, tile = 5;
constexpr unsigned header = 4; ///< words at the start of the out buffer: tiles wanted, entries wanted, two spare words;
                               ///< then one byte per row
} // namespace words

} // namespace oncollide::gl
