#pragma once
#include <compare>
#include <cstdint>

#include <oncollide/scenes/model/cell_tree.hpp>

namespace oncollide {

/// A part of a body: a triangle of a mesh or terrain, or an occupied cube of a map, as large as the octree stores it. A
/// shape is one part.
struct BodyPart {
    std::uint32_t triangle = 0; ///< number of the triangle; 0 if the part is none
    MapCell cell{0, 0, 0, 0};   ///< side 0 if the part is no cell

    BodyPart() = default;
    BodyPart(std::uint32_t number) : triangle(number) {}
    BodyPart(const MapCell& cube) : cell(cube) {}
    friend auto operator<=>(const BodyPart&, const BodyPart&) = default;
};

} // namespace oncollide
