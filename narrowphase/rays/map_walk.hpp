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
        const std::optional<SegmentPart> part = part_in(segment, tree.map().bounds());
        if (!part) return;
        const Eigen::Vector3d around = part->half.cwiseAbs().array() + 2 * part->error;
        const auto first = tree.octant_around({part->middle - around, part->middle + around});
        if (!first) return;
        const Line line(segment, tree.map().resolution());
        std::size_t waiting = 0;
        double limit = reach;
        const auto push = [&](Cube& cube) { waiting += (cube.enters = line.entry(cube, limit)) <= limit; };
        waiting_[0].parent = first->of, waiting_[0].octant = first->number, waiting_[0].leaf = first->whole;
        line.set_planes(first->of.cube.octant(first->number), waiting_[0]), push(waiting_[0]);
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
            double entries[8];
            // The farthest first, so that the nearest comes next.
            for (unsigned met = line.backed(solid & line.octants(cube, middle, limit, entries)); met;) {
                const unsigned order = 31 - static_cast<unsigned>(__builtin_clz(met)), octant = order ^ line.backward;
                met ^= 1u << order;
                Cube& next = waiting_[waiting++];
                for (unsigned axis = 0; axis < 3; ++axis) {
                    const bool high = octant >> axis & 1;
                    next.low[axis] = high ? middle[axis] : cube.low[axis];
                    next.high[axis] = high ? cube.high[axis] : middle[axis];
                }
                next.enters = entries[octant];
                next.parent = node, next.octant = octant, next.leaf = leaves >> octant & 1;
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

        /// One bit for each octant of a cube that the segment enters by `limit`. Writes the octants' `enters`.
        unsigned octants(const Cube& cube, const double (&middle)[3], double limit, double (&entries)[8]) const
        {
            constexpr double never = std::numeric_limits<double>::infinity();
            double enters[3][2], leaves[3][2]; // by axis and half
            for (unsigned axis = 0; axis < 3; ++axis) {
                const bool back = backward >> axis & 1;
                const double low = cube.low[axis], high = cube.high[axis], between = middle[axis];
                if (along[axis]) {
                    enters[axis][0] = back ? between : low, leaves[axis][0] = back ? low : between;
                    enters[axis][1] = back ? high : between, leaves[axis][1] = back ? between : high;
                } else {
                    enters[axis][0] = low > most[axis] || between < least[axis] ? never : 0;
                    enters[axis][1] = between > most[axis] || high < least[axis] ? never : 0;
                    leaves[axis][0] = leaves[axis][1] = limit;
                }
            }
            unsigned met = 0;
            for (unsigned yz = 0; yz < 4; ++yz) {
                const double first = std::max(std::max(enters[1][yz & 1], enters[2][yz >> 1]), 0.0),
                             last = std::min(std::min(leaves[1][yz & 1], leaves[2][yz >> 1]), limit);
                for (unsigned x = 0; x < 2; ++x) {
                    const double entry = entries[2 * yz + x] = std::max(enters[0][x], first) * (1 - 0x1p-50);
                    met |= unsigned{entry <= std::min(leaves[0][x], last) * (1 + 0x1p-50)} << (2 * yz + x);
                }
            }
            return met;
        }
        /// The mask by order along the segment: bit k becomes bit k ^ backward.
        unsigned backed(unsigned mask) const
        {
            if (backward & 1) mask = (mask & 0x55) << 1 | (mask >> 1 & 0x55);
            if (backward & 2) mask = (mask & 0x33) << 2 | (mask >> 2 & 0x33);
            if (backward & 4) mask = (mask & 0x0f) << 4 | mask >> 4;
            return mask;
        }

        Eigen::Vector3d from, least, most, per_metre;
        double resolution;
        bool along[3];
        unsigned backward = 0; ///< bit k: the segment leads against axis k
    };

    std::array<Cube, 8 * 18> waiting_; ///< up to 7 for each of the 17 levels
};

} // namespace oncollide
