#pragma once
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include <oncollide/narrowphase/obb/map_tree.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/shapes/cell_test.hpp>
#include <oncollide/scenes/model/box_corners.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

/// The primitives of B in tests against a map's cells: triangles of a mesh or a terrain, or another map's cells, moved
/// into A's frame in double.
struct PlacedTriangles {
    using Tree = ObbTree;
    using Placed = TrianglePoints;
    static Placed place(const ObbTree& b, const RelativePose& b_to_a, std::uint32_t triangle)
    {
        TrianglePoints points = b.corners(triangle);
        for (Eigen::Vector3d& p : points) p = b_to_a(p);
        return points;
    }
    static double low(const ObbTree& b, std::uint32_t triangle, const Eigen::Vector3d& line)
    {
        return least_along(line, b.corners(triangle));
    }
    static bool meet(const Aabb& cell, const Placed& b) { return cell_meets(cell, b); }
    static NearestPoints nearest(const Aabb& cell, const Placed& b, double rounding)
    {
        return cell_nearest(cell, b, rounding);
    }
    static double most(const Aabb& cell, const Placed& b) { return cell_distance_at_most(cell, b); }
    static double gap(const Aabb& cell, const Placed& b, double rounding) { return cell_gap(cell, b, rounding); }
};
struct PlacedTerrain : PlacedTriangles {
    using Tree = TerrainTree;
    static Placed place(const TerrainTree& b, const RelativePose& b_to_a, std::uint32_t triangle)
    {
        TrianglePoints points = b.points(triangle);
        for (Eigen::Vector3d& p : points) p = b_to_a(p);
        return points;
    }
    static double low(const TerrainTree& b, std::uint32_t triangle, const Eigen::Vector3d& line)
    {
        return least_along(line, b.points(triangle));
    }
};
struct PlacedCells {
    using Tree = MapTree;
    using Placed = CellCorners;
    static Placed place(const MapTree& b, const RelativePose& b_to_a, const MapCell& cell)
    {
        const Aabb box = MapAccess::box(b.map(), cell);
        CellCorners corners;
        for (unsigned k = 0; k < 8; ++k) corners[k] = b_to_a(corner_of(box, k));
        return corners;
    }
    static double low(const MapTree& b, const MapCell& cell, const Eigen::Vector3d& line)
    {
        const Aabb box = MapAccess::box(b.map(), cell);
        return line.cwiseProduct(box.min).cwiseMin(line.cwiseProduct(box.max)).sum();
    }
    static bool meet(const Aabb& cell, const Placed& b) { return cells_meet(cell, b); }
    static NearestPoints nearest(const Aabb& cell, const Placed& b, double rounding)
    {
        return cells_nearest(cell, b, rounding);
    }
    static double most(const Aabb& cell, const Placed& b) { return cell_distance_at_most(cell, {b[0], b[3], b[7]}); }
    static double gap(const Aabb& cell, const Placed& b, double rounding)
    {
        double least = std::numeric_limits<double>::infinity();
        for (const auto& [i, j, k] : box_faces) least = std::min(least, cell_gap(cell, {b[i], b[j], b[k]}, rounding));
        return least;
    }
};

/// The leaf tests of a map, A, against a mesh or another map (see hierarchy.hpp): exact signs; a cell is a solid box in
/// the map's own coordinates.
template <class Placing>
class CellTests {
public:
    using B = typename Placing::Tree;
    struct Pair {
        MapCell a;
        typename B::Primitive b;
    };

    void start(const MapTree& a, const B& b, const RelativePose& b_to_a)
    {
        map_ = &a.map(), b_ = &b, b_to_a_ = &b_to_a;
        apart_.clear();
    }
    template <class Found>
    bool meeting(std::span<const Pair> pairs, Found found)
    {
        for (const Pair& pair : pairs) {
            if (!meet(pair))
                apart_.push_back(pair);
            else if (!found(pair))
                return false;
        }
        return true;
    }
    double least_gap(double rounding) const
    {
        double least = std::numeric_limits<double>::infinity();
        for (const Pair& pair : apart_) least = std::min(least, Placing::gap(cell(pair), placed(pair), rounding));
        return least;
    }
    bool meet(const Pair& pair)
    {
        ++tested;
        return Placing::meet(cell(pair), placed(pair));
    }
    double most(const Pair& pair) const { return Placing::most(cell(pair), placed(pair)); }
    double high_a(const MapCell& a, const Eigen::Vector3d& line) const
    {
        const Aabb box = MapAccess::box(*map_, a);
        return line.cwiseProduct(box.min).cwiseMax(line.cwiseProduct(box.max)).sum();
    }
    double low_b(const typename B::Primitive& b, const Eigen::Vector3d& line) const
    {
        return Placing::low(*b_, b, line);
    }
    NearestPoints nearest(const Pair& pair, double rounding)
    {
        ++tested;
        return Placing::nearest(cell(pair), placed(pair), rounding);
    }

    std::uint64_t tested = 0; ///< pairs

private:
    Aabb cell(const Pair& pair) const { return MapAccess::box(*map_, pair.a); }
    typename Placing::Placed placed(const Pair& pair) const { return Placing::place(*b_, *b_to_a_, pair.b); }

    const OccupancyMap* map_ = nullptr;
    const B* b_ = nullptr;
    const RelativePose* b_to_a_ = nullptr;
    std::vector<Pair> apart_;
};

} // namespace oncollide
