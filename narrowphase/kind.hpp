#pragma once
#include <cstddef>
#include <cstdint>
#include <variant>

#include <oncollide/narrowphase/shapes/polytope_surface.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// The kinds of models that have tests of their own (pairs/pair_tests.hpp).
enum class Kind : std::uint8_t {
    mesh,
    terrain,
    map,
    polytope, ///< a box or a hull
    round,    ///< any other bounded shape
    half_space,
};
constexpr std::size_t kind_count = 6;

inline Kind kind_of(const GeometryData& data)
{
    if (std::holds_alternative<Terrain>(data)) return Kind::terrain;
    if (std::holds_alternative<OccupancyMap>(data)) return Kind::map;
    const Shape* const shape = std::get_if<Shape>(&data);
    if (!shape) return Kind::mesh;
    if (std::holds_alternative<HalfSpace>(*shape)) return Kind::half_space;
    return is_polytope(*shape) ? Kind::polytope : Kind::round;
}

} // namespace oncollide
