#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/broadphase/box_kernel.hpp>
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

/// Of points, for all directions in each cell of a cube, those that may be farthest along them: a dozen, whatever the
/// number of points, and none that is well inside. Cells are sorted out as directions come that go through them.
class SupportMap {
public:
    SupportMap() = default;
    /// Cost: O(points); 12 bytes each.
    explicit SupportMap(PointColumns points);

    bool empty() const { return cells_.empty(); }
    /// One in so many boxes is to be prepared for.
    static constexpr std::uint32_t boxes_a_look = 4;
    /// Such boxes along such axes, the rows of a rotation, are about to be requested: sorts out what pays. Not beside
    /// other calls. Results do not depend on it.
    void prepare(const Eigen::Matrix3f& rows);
    /// Sorts out all that is left. Cost: 0.2 microseconds and 30 to 60 bytes a point of a closed surface.
    void complete();

    /// The least and the most that the points show along the rows of a rotation, but for the rounding of products and
    /// sums in float; the same on every instruction set. Cost: 0.1 microseconds, once it is sorted out there.
    void box(const Eigen::Matrix3f& rows, Eigen::Vector3f& lo, Eigen::Vector3f& hi) const;
    std::size_t bytes() const;

private:
    /// Those of the points that may be farthest along a direction of some cells: a square of them on a face, or all.
    struct Square {
        PointRange points;
        std::uint32_t side;  ///< cells; twice a face's: all
        std::uint32_t looks; ///< at them, about
    };
    std::uint32_t cell(std::uint32_t face, float u, float v) const;
    std::array<std::uint32_t, 6> cells_along(const Eigen::Matrix3f& rows) const;
    static bool divisible(const Square& square);
    void divide(std::uint32_t cell);
    PointRange farthest(std::uint32_t face, std::uint32_t x, std::uint32_t y, std::uint32_t side, PointRange among);

    float rounding_ = 0;            ///< of products and sums
    std::uint32_t side_ = 0;        ///< cells along an edge of the cube
    PointColumns points_;           ///< list by list, each padded to 8 with copies
    std::vector<PointRange> cells_; ///< lists by cell
    // Until it is complete:
    std::vector<Square> squares_;
    std::vector<std::uint32_t> square_of_; ///< by cell
    std::vector<float> along_;             ///< scratch, as the next
    std::vector<std::int32_t> keep_;
};

} // namespace oncollide
