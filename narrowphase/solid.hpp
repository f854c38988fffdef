#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Tells whether one body lies inside another, for bodies whose surfaces do not meet. Closed meshes and shapes have an
/// inside; open meshes and maps (whose cells are solid already) do not.
class SolidTest {
public:
    explicit SolidTest(const Scene& scene);

    /// True when a part of body a lies inside b, or of b inside a, given that their surfaces do not touch: then one
    /// vertex tells for each connected part. Cost: O(triangles) of the outer mesh for each part that begins in its box.
    bool encloses(const Scene& scene, std::uint32_t a, std::uint32_t b) const;

    /// Has the geometry an inside?
    bool solid(GeometryId geometry) const { return solid_[static_cast<std::uint32_t>(geometry)]; }

private:
    bool holds(const Scene& scene, std::uint32_t outer, std::uint32_t inner) const;

    std::vector<std::uint8_t> solid_;                 ///< by geometry
    std::vector<std::vector<Eigen::Vector3d>> parts_; ///< by geometry: a point of each connected part
};

/// How often the closed mesh winds around `point` (mesh frame, not on the surface): 0 outside, 1 inside.
/// Source: van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 1983.
double winding_number(const Mesh& mesh, const Eigen::Vector3d& point);

} // namespace oncollide
