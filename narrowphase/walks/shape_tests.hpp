#pragma once
#include <algorithm>
#include <optional>
#include <span>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/obb/map_tree.hpp>
#include <oncollide/narrowphase/obb/shape_tree.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>
#include <oncollide/narrowphase/walks/triangle_tests.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

/// The leaf tests of a shape, A, against the triangles of a mesh or a terrain (see hierarchy.hpp). Certain results
/// count as meeting or as apart; open_bound() covers pairs that rounding leaves undecided.
template <class Tree>
class ShapeTriangleTests {
public:
    struct Pair {
        std::uint32_t a, b;
    };
    void start(const ShapeTree& shape, const Tree& tree, const RelativePose& tree_to_shape)
    {
        shape_ = &shape.shape(), into_ = &tree_to_shape;
        corners_.start(tree);
    }
    ConvexMeeting meeting(const Pair& pair) const
    {
        const TrianglePoints corners = corners_.points(pair.b);
        const Convex solid = convex_of(corners);
        return ConvexPair(*shape_, solid, *into_, slack_).meeting();
    }
    ConvexDistance bounds(const Pair& pair, const DistanceGoal& goal) const
    {
        const TrianglePoints corners = corners_.points(pair.b);
        const Convex solid = convex_of(corners);
        return ConvexPair(*shape_, solid, *into_, slack_).distance(goal);
    }
    double high_a(std::uint32_t, const Eigen::Vector3d& line) const { return shape_->most_along(line); }
    double low_b(std::uint32_t triangle, const Eigen::Vector3d& line) const
    {
        return least_along(line, corners_.points(triangle));
    }

private:
    const Convex* shape_ = nullptr;
    TriangleCorners<Tree> corners_;
    const RelativePose* into_ = nullptr;

protected:
    double slack_ = 0;
};

/// The same for a map, A, and a shape.
class MapShapeTests {
public:
    struct Pair {
        MapCell a;
        std::uint32_t b;
    };
    void start(const MapTree& map, const ShapeTree& shape, const RelativePose& shape_to_map)
    {
        shape_ = &shape.shape(), into_ = &shape_to_map, map_ = &map.map();
    }
    ConvexMeeting meeting(const Pair& pair) const
    {
        const Convex solid = convex_of(MapAccess::box(*map_, pair.a));
        return ConvexPair(solid, *shape_, *into_, slack_).meeting();
    }
    ConvexDistance bounds(const Pair& pair, const DistanceGoal& goal) const
    {
        const Convex solid = convex_of(MapAccess::box(*map_, pair.a));
        return ConvexPair(solid, *shape_, *into_, slack_).distance(goal);
    }
    double high_a(const MapCell& cell, const Eigen::Vector3d& line) const
    {
        const Aabb box = MapAccess::box(*map_, cell);
        return line.cwiseProduct(box.min).cwiseMax(line.cwiseProduct(box.max)).sum();
    }
    double low_b(std::uint32_t, const Eigen::Vector3d& line) const { return -shape_->most_along(-line); }

private:
    const Convex* shape_ = nullptr;
    const RelativePose* into_ = nullptr;
    const OccupancyMap* map_ = nullptr;

protected:
    double slack_ = 0;
};

/// Makes leaf tests from a test of one pair.
template <class Judge>
class RoundTests : public Judge {
public:
    using Pair = typename Judge::Pair;

    /// @param slack        see ConvexPair
    /// @param open_counts  true: pairs that rounding leaves undecided count as meeting
    void prepare(double slack, bool open_counts)
    {
        this->slack_ = slack, open_counts_ = open_counts;
        open_bound_ = infinity;
    }
    void start(const auto& a, const auto& b, const RelativePose& b_to_a)
    {
        Judge::start(a, b, b_to_a);
        least_ = infinity;
    }
    template <class Found>
    bool meeting(std::span<const Pair> pairs, Found found)
    {
        for (const Pair& pair : pairs)
            if (meet(pair) && !found(pair)) return false;
        return true;
    }
    double least_gap(double) const { return least_; }
    bool meet(const Pair& pair)
    {
        ++tested;
        const ConvexMeeting m = Judge::meeting(pair);
        if (m.sign > 0) least_ = std::min(least_, m.bound);
        if (m.sign == 0) open_bound_ = std::min(open_bound_, m.bound);
        return m.sign < 0 || (m.sign == 0 && open_counts_);
    }
    bool certainly_meet(const Pair& pair) const { return Judge::meeting(pair).sign < 0; }
    ConvexDistance bounds(const Pair& pair) const { return Judge::bounds(pair, {}); }
    NearestPoints nearest(const Pair& pair, double) const
    {
        const ConvexDistance d = bounds(pair);
        return {d.on_a, d.on_b, d.upper};
    }
    double most(const Pair& pair) const { return Judge::bounds(pair, {.cutoff = 0}).upper; }

    /// Upper bound of the distance of a pair that rounding left undecided; infinite: there was none.
    double open_bound() const { return open_bound_; }
    std::uint64_t tested = 0; ///< pairs

private:
    double least_ = infinity, open_bound_ = infinity;
    bool open_counts_ = false;
};

} // namespace oncollide
