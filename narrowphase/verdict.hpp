#pragma once
#include <cstdint>
#include <string_view>

namespace oncollide {

/// What is certain about a pair of bodies at the end of a frame.
enum class Verdict : std::uint8_t {
    separate,  ///< distance > clearance, and at least the bound
    within,    ///< distance <= the bound; may or may not collide
    colliding, ///< the exact level found intersecting triangles, or one solid body encloses the other
    undecided, ///< a budget or a skipped stage stopped refinement; distance <= the bound reached so far
};

constexpr std::string_view name_of(Verdict verdict)
{
    constexpr std::string_view names[] = {"separate", "within", "colliding", "undecided"};
    return names[static_cast<int>(verdict)];
}

} // namespace oncollide
