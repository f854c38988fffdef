#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Points as columns, for kernels.
struct PointColumns {
    std::array<std::vector<float>, 3> xyz;

    std::size_t size() const { return xyz[0].size(); }
    void add(float x, float y, float z) { xyz[0].push_back(x), xyz[1].push_back(y), xyz[2].push_back(z); }
    void add(const PointColumns& other, std::size_t i) { add(other.xyz[0][i], other.xyz[1][i], other.xyz[2][i]); }
    std::size_t bytes() const { return (xyz[0].capacity() + xyz[1].capacity() + xyz[2].capacity()) * sizeof(float); }
};

/// Points about a centre, padded to a multiple of 8 with copies.
PointColumns point_columns(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre);
/// Those of a mesh's vertices that triangles use.
PointColumns used_points(const Mesh& mesh, const Eigen::Vector3d& centre);

/// Of points, for all directions in each cell of a cube, those that may be farthest along them: a hundred or two,
/// whatever the number of points, and none that is well inside.
class SupportMap {
public:
    SupportMap() = default;
    /// Cost: 0.3 to 0.8 microseconds and 15 to 40 bytes a point of a closed surface.
    explicit SupportMap(const PointColumns& points);

    bool empty() const { return ends_.empty(); }
    /// The most that the points show along a direction of a length of about 1, but for the rounding of products and
    /// sums in float; the same on every instruction set. Cost: 70 to 130 ns.
    float most(const Eigen::Vector3f& direction) const;
    std::size_t bytes() const { return points_.bytes() + ends_.capacity() * sizeof(ends_[0]); }

private:
    class Filling;

    std::uint32_t side_ = 0;          ///< cells along an edge of the cube
    PointColumns points_;             ///< cell by cell, each padded to 8 with copies
    std::vector<std::uint32_t> ends_; ///< by cell: where its points end, and the next one's begin
};

} // namespace oncollide
