#pragma once
#include <vector>

#include <oncollide/scenes/model/terrain.hpp>

#include "verify/cases/case_numbers.hpp"
#include "verify/cases/placed_body.hpp"

namespace oncollide::tools {

class TerrainDraw : public CaseNumbers {
public:
    using CaseNumbers::CaseNumbers;
    /// A vector of integral length, and that length.
    Place away(std::int64_t& length);
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
