#pragma once
#include <random>
#include <vector>

#include <oncollide/scenes/model/terrain.hpp>

#include "verify/oracle/integer_distance.hpp"

namespace oncollide::tools {

/// Position and scale of a body: a unit of the grid is 2^exponent metres, and everything is shifted by `offset`.
struct GridFrame {
    double unit;
    Eigen::Vector3d offset;

    Eigen::Vector3d point(const Place& p) const
    {
        return unit * Eigen::Vector3d(double(p[0]), double(p[1]), double(p[2]));
    }
};

class TerrainDraw {
public:
    explicit TerrainDraw(std::uint64_t seed) : random_(seed) {}
    std::int64_t number(std::int64_t least, std::int64_t most)
    {
        return std::uniform_int_distribution<std::int64_t>(least, most)(random_);
    }
    bool one_in(std::int64_t n) { return number(1, n) == 1; }
    /// A vector of integral length, and that length.
    Place away(std::int64_t& length);

private:
    std::mt19937_64 random_;
};

/// A small terrain of integers, with holes and both diagonals; cells are 2^11 wide. Planes whose normals have integral
/// length, steps, peaks and rough ground.
struct TerrainShape {
    static constexpr std::int64_t width = 1 << 11;
    std::uint32_t columns, rows;
    std::vector<std::int64_t> heights;
    std::vector<bool> hole, falling;
    Place normal{}; ///< of a plane; 0: not a plane

    explicit TerrainShape(TerrainDraw& draw, bool fine = false);
    Place point(std::uint32_t column, std::uint32_t row) const
    {
        return {width * column, width * row, heights[row * columns + column]};
    }
    /// Triangles of all existing cells.
    std::vector<PlaceTriangle> triangles() const;
    /// A random point on a vertex, an edge or a face.
    Place feature(TerrainDraw& draw) const;
    /// @param origin   the terrain's own origin, which its pose compensates
    /// @param off_by   heights are changed by up to this, which is given as their error
    Terrain made(double unit, const Place& origin, int bytes, double off_by = 0) const;
};

} // namespace oncollide::tools
