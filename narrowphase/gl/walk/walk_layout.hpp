// The layout of the buffers that the host and the shaders share. Units are words of four bytes unless a name ends in
// `bytes`.
#pragma once
#include <cstdint>

namespace oncollide::gl::walk {

/// Binding points. OpenGL guarantees eight of them for a compute shader.
namespace slot {
constexpr unsigned words = 0, vertices = 1, trees = 2, poses = 3, pairs = 4, frames = 5, items = 6, out = 7;
}

constexpr std::uint32_t rounds = 8;      ///< dispatches of the walk; the last one leaves the rest open
constexpr std::uint32_t team = 8;        ///< invocations that test one box against a node's boxes
constexpr std::uint32_t teams = 4;       ///< in a work group
constexpr std::uint32_t stack_room = 64; ///< entries of a team's stack; further entries go to the next round

constexpr std::uint32_t pair_words = 8;    ///< pose a, pose b, tree a, tree b, hint a, hint b, enough, unused
constexpr std::uint32_t frame_bytes = 192; ///< 14 doubles, 20 floats
constexpr std::uint32_t item_words = 3;    ///< pair, box of a, box of b: eight times the node, plus the box

// The results: a header, then four words for each pair, then the lists.
constexpr std::uint32_t header_words = 64;
namespace header {
constexpr std::uint32_t unsure = 0, wanted = 1, box_rows = 2, triangles = 3, dropped = 4;
constexpr std::uint32_t queued = 16; ///< by round: items in its queue
constexpr std::uint32_t taken = 32;  ///< by round: items that teams took
} // namespace header
constexpr std::uint32_t result_words = 4; ///< state, bound, triangle a, triangle b
constexpr std::uint32_t unsure_words = 3, wanted_words = 3;

/// Bits of a pair's state. The rest of the word counts the pair's items that no team has ended yet. If a driver ends a
/// shader too soon (llvmpipe ends loops after 65,535 passes), this count stays above 0, and the pair is open.
namespace state {
constexpr std::uint32_t met = 1, open = 2, unsure = 4, item = 256;
}

/// A tree, as in the shaders.
struct GpuTree {
    double centre[3], radius;
    std::uint32_t nodes, order, triangles; ///< first words
    std::uint32_t vertices;                ///< first number of the buffer of vertices
    std::uint32_t spare[4];
};
static_assert(sizeof(GpuTree) == 64);

struct GpuPair {
    std::uint32_t pose_a, pose_b, tree_a, tree_b, hint_a, hint_b;
    float enough;
    std::uint32_t spare;
};
static_assert(sizeof(GpuPair) == 4 * pair_words);

} // namespace oncollide::gl::walk
