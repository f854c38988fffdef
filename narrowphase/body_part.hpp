#pragma once
#include <compare>
#include <cstdint>

#include <oncollide/scenes/model/cell_tree.hpp>

namespace oncollide {

/// One of the parts that a body is made of: of a mesh or a terrain a triangle, of a map a cube of occupied cells, as
/// large as the octree has it. A shape is one part.
struct BodyPart {
    std::uint32_t triangle = 0; ///< its number; 0 of others
    MapCell cell{0, 0, 0, 0};   ///< side 0 of others

    BodyPart() = default;
    BodyPart(std::uint32_t number) : triangle(number) {}
    BodyPart(const MapCell& cube) : cell(cube) {}
    friend auto operator<=>(const BodyPart&, const BodyPart&) = default;
};

} // namespace oncollide
