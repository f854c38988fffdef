#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Points of a connected part of a geometry: of a mesh its least and largest vertices along the axes. Where the part
/// does not meet a surface, all of it is on one side: one point tells, and the others quickly show where that is not
/// the inside.
using PartPoints = std::array<Eigen::Vector3d, 6>;

/// Which geometries of a scene have an inside, and the points that tell whether they lie inside others.
class Solids {
public:
    /// Of the geometries that bodies use. Closed meshes have an inside; shapes and the cells of maps have theirs in
    /// every mode already, and count as none here. Throws Error{bad_data} naming a mesh that is not closed and its
    /// first open edges, unless `open_as_surface`: then it has no inside. Cost: O(n log n).
    Solids(const Scene& scene, bool open_as_surface);

    bool solid(GeometryId geometry) const { return solid_[index(geometry)]; }
    std::span<const PartPoints> parts(GeometryId geometry) const { return parts_[index(geometry)]; }

private:
    std::vector<std::uint8_t> solid_;            ///< by geometry
    std::vector<std::vector<PartPoints>> parts_; ///< by geometry; of a map each cell is one
};

} // namespace oncollide
