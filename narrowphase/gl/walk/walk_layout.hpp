// The layout of the buffers that the host and the shaders share. Units are words of four bytes unless a name ends in
// `bytes`.
#pragma once
#include <cstdint>

namespace oncollide::gl::walk {

/// Binding points. OpenGL guarantees eight of them for a compute shader.
namespace slot {
constexpr unsigned words = 0, vertices = 1, trees = 2, pairs = 3, frames = 4, items = 5, out = 6;
}

constexpr std::uint32_t rounds = 8;      ///< dispatches of the walk; the last one leaves the rest open
constexpr std::uint32_t team = 8;        ///< invocations that test one box against a node's boxes
constexpr std::uint32_t teams = 4;       ///< in a work group
constexpr std::uint32_t stack_room = 64; ///< entries of a team's stack; further entries go to the next round

constexpr std::uint32_t frame_bytes = 96; ///< 2 doubles, 20 floats
constexpr std::uint32_t item_words = 3;   ///< pair, box of a, box of b: eight times the node, plus the box
/// A team that leaves this many pairs of triangles to exact arithmetic ends its walk, because two of them probably
/// meet.
constexpr std::uint32_t most_unsure = 32;

// The results: a header, then four words for each pair, then the lists.
constexpr std::uint32_t header_words = 64;
namespace header {
constexpr std::uint32_t unsure = 0, wanted = 1, box_rows = 2, triangles = 3, dropped = 4;
constexpr std::uint32_t queued = 8; ///< by round: items in its queue
constexpr std::uint32_t taken = 20; ///< by round: items that teams took
constexpr std::uint32_t groups =
    32; ///< by round: the three arguments of its dispatch; teams take items until none is left
} // namespace header
constexpr std::uint32_t result_words = 4; ///< state, bound, triangle a, triangle b
constexpr std::uint32_t unsure_words = 3, wanted_words = 3;

/// A tree, as in the shaders.
struct GpuTree {
    double centre[3], radius;
    std::uint32_t nodes, order, triangles; ///< first words
    std::uint32_t vertices;                ///< first number of the buffer of vertices
    std::uint32_t spare[4];
};
static_assert(sizeof(GpuTree) == 64);

static_assert(header::queued + rounds < header::taken && header::taken + rounds < header::groups &&
              header::groups + 3 * (rounds + 1) <= header_words);

} // namespace oncollide::gl::walk
