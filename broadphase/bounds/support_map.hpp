#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/broadphase/aabb_kernel.hpp>
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

/// The points relative to a centre, padded with copies to a multiple of 8.
PointColumns point_columns(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre);
/// The same, in `columns`. Allocates nothing if there is room for them.
void set_columns(PointColumns& columns, std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre);
/// The mesh's vertices that triangles use.
PointColumns used_points(const Mesh& mesh, const Eigen::Vector3d& centre);

/// For each cell of a cube map of directions, the points that can be support points along a direction in the cell:
/// about a dozen, independent of the number of points; interior points are never included. Cells are refined when a
/// direction in them is used.
class SupportMap {
public:
    SupportMap() = default;
    /// Cost: O(points), 12 bytes per point.
    explicit SupportMap(PointColumns points);

    bool empty() const { return cells_.empty(); }
    /// Call prepare() for one box in this many.
    static constexpr std::uint32_t boxes_a_look = 4;
    /// Announces boxes() along such axes, the rows of a rotation: refines cells if this pays off. Not concurrently with
    /// any other call. Does not affect results.
    void prepare(const Eigen::Matrix3f& rows);
    /// Refines all cells. Cost: 0.2 microseconds and 30 to 60 bytes per point of a closed surface.
    void complete();

    /// The smallest and largest projections of the points onto the rows of a rotation, apart from rounding in float;
    /// identical on every instruction set. Cost: 0.1 microseconds once the cells are refined.
    void box(const Eigen::Matrix3f& rows, Eigen::Vector3f& lo, Eigen::Vector3f& hi) const;
    std::size_t bytes() const;

private:
    /// Candidates for support points along the directions of a square of cells on one face, or of all cells.
    struct Square {
        PointRange points;
        std::uint32_t side;  ///< edge length in cells; twice the edge of a face means all cells
        std::uint32_t looks; ///< approximate number of scans of the list
    };
    std::uint32_t cell(std::uint32_t face, float u, float v) const;
    std::array<std::uint32_t, 6> cells_along(const Eigen::Matrix3f& rows) const;
    static bool divisible(const Square& square);
    void divide(std::uint32_t cell);
    PointRange farthest(std::uint32_t face, std::uint32_t x, std::uint32_t y, std::uint32_t side, PointRange among);

    float rounding_ = 0;            ///< error bound of products and sums
    std::uint32_t side_ = 0;        ///< cells along an edge of the cube
    PointColumns points_;           ///< list by list, each padded to 8 with copies
    std::vector<PointRange> cells_; ///< lists by cell
    // Used until complete():
    std::vector<Square> squares_;
    std::vector<std::uint32_t> square_of_; ///< by cell
    std::vector<float> along_;             ///< scratch, like keep_
    std::vector<std::int32_t> keep_;
};

} // namespace oncollide
