#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/obb/map_tree.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>

namespace oncollide {

/// The walk through the octree of a map, front to back. Octants share the planes between them, so a step finds three
/// fractions. Source: Revelles, Ureña and Lastra, "An efficient parametric algorithm for octree traversal", WSCG 2000.
template <>
class SegmentWalk<MapTree> {
public:
    /// As SegmentWalk::walk() of other trees; cells come in the order in which the segment enters them.
    template <class Take>
    void walk(const MapTree& tree, const Segment& segment, Take take, double reach = 1)
    {
        const Line line(segment, tree.map().resolution());
        std::size_t waiting = 0;
        double limit = reach;
        const auto push = [&](Cube& cube) { waiting += (cube.enters = line.entry(cube, limit)) <= limit; };
        waiting_[0].parent = MapTree::root, waiting_[0].octant = 0, waiting_[0].leaf = false;
        line.set_planes(CellTree::top_cube, waiting_[0]), push(waiting_[0]);
        while (waiting) {
            Cube cube = waiting_[--waiting];
            if (cube.enters > limit) continue;
            if (cube.leaf) {
                limit = std::min(limit, take(cube.parent.cube.octant(cube.octant)));
                if (limit < 0) return;
                continue;
            }
            // Nodes are read only when their turn comes: most of the time is waiting for them.
            const MapTree::Node node = tree.child(cube.parent, cube.octant);
            const MapCell& c = node.cube;
            if (2 * c.side != cube.parent.cube.side) { // single children were skipped
                line.set_planes(c, cube);
                if (line.entry(cube, limit) > limit) continue;
            }
            const unsigned solid = tree.solid(node), leaves = tree.whole(node) & solid;
            const std::int32_t half = c.side / 2;
            const double middle[] = {line.at(c.x + half, 0), line.at(c.y + half, 1), line.at(c.z + half, 2)};
            for (unsigned order = 8; order-- > 0;) { // the farthest first, so that the nearest comes next
                const unsigned octant = order ^ line.backward;
                if (!(solid >> octant & 1)) continue;
                Cube& next = waiting_[waiting];
                for (unsigned axis = 0; axis < 3; ++axis) {
                    const bool high = octant >> axis & 1;
                    next.low[axis] = high ? middle[axis] : cube.low[axis];
                    next.high[axis] = high ? cube.high[axis] : middle[axis];
                }
                next.parent = node, next.octant = octant, next.leaf = leaves >> octant & 1;
                push(next);
            }
        }
    }

private:
    struct Cube {
        MapTree::Node parent;
        unsigned octant;                 ///< of the parent
        bool leaf;                       ///< a solid cell, or a cube of them
        double enters;                   ///< a lower bound of the fraction at which the segment enters; infinite: never
        std::array<double, 3> low, high; ///< its planes, as Line::at() has them
    };

    struct Line {
        Line(const Segment& segment, double side_of_cells)
            : from(segment.from), least(segment.from.cwiseMin(segment.to)), most(segment.from.cwiseMax(segment.to)),
              resolution(side_of_cells)
        {
            for (int axis = 0; axis < 3; ++axis) {
                const double way = segment.to[axis] - segment.from[axis];
                along[axis] = std::abs(way) > 0x1p-900;
                per_metre[axis] = along[axis] ? 1 / way : 0;
                backward |= unsigned{way < 0 && along[axis]} << axis;
            }
        }
        /// The fraction of the segment at the plane before a cell, with an error of 4 u, u = 2^-53. Along an axis on
        /// which the segment hardly moves: the plane's coordinate.
        double at(std::int32_t cell, int axis) const
        {
            const double plane = cell * resolution; // as MapAccess::box() has it
            return along[axis] ? (plane - from[axis]) * per_metre[axis] : plane;
        }
        void set_planes(const MapCell& cube, Cube& to) const
        {
            const std::int32_t corner[3] = {cube.x, cube.y, cube.z};
            for (int axis = 0; axis < 3; ++axis) {
                to.low[std::size_t(axis)] = at(corner[axis], axis);
                to.high[std::size_t(axis)] = at(corner[axis] + cube.side, axis);
            }
        }
        /// The cube's `enters`.
        /// @param limit  of the fractions that count
        double entry(const Cube& cube, double limit) const
        {
            constexpr double never = std::numeric_limits<double>::infinity();
            double enters = 0, leaves = limit;
            for (unsigned axis = 0; axis < 3; ++axis) {
                const double low = cube.low[axis], high = cube.high[axis];
                if (along[axis]) {
                    const bool back = backward >> axis & 1;
                    enters = std::max(enters, back ? high : low), leaves = std::min(leaves, back ? low : high);
                } else if (low > most[axis] || high < least[axis]) {
                    return never;
                }
            }
            enters *= 1 - 0x1p-50;
            return enters <= leaves * (1 + 0x1p-50) ? enters : never;
        }

        Eigen::Vector3d from, least, most, per_metre;
        double resolution;
        bool along[3];
        unsigned backward = 0; ///< bit k: the segment leads against axis k
    };

    std::array<Cube, 8 * 18> waiting_; ///< up to 7 for each of the 17 levels
};

} // namespace oncollide
