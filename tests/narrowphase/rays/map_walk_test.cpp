// Segments through maps: the walk through the octree, compared with tests of all cubes.
#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/rays/map_walk.hpp>
#include <oncollide/narrowphase/rays/segment_tests.hpp>

namespace oncollide::map_walk_test {
namespace {

using Eigen::Vector3d;

/// Random cubes of cells of several sizes around a corner, of which some are free.
OccupancyMap make(const Eigen::Vector3i& corner, int extent, int cubes, bool unknown_is_occupied, std::uint64_t seed)
{
    std::vector<MapCell> occupied, free;
    for (std::uint64_t i = 0; i < std::uint64_t(cubes); ++i) {
        const std::int32_t side = 1 << int(3 * u01(seed, i, 3));
        const auto at = [&](std::uint64_t axis) {
            return corner[int(axis)] + side * int(u01(seed, i, axis) * extent / side);
        };
        (u01(seed, i, 4) < 0.7 ? occupied : free).push_back({at(0), at(1), at(2), side});
    }
    return make_occupancy_map("cubes", 0.25, occupied, free, unknown_is_occupied);
}

/// Segments upright, along an axis, in planes between cells, from corner to corner, short, long, and points.
Segment segment_in(const OccupancyMap& map, std::uint64_t seed)
{
    const Aabb& box = map.bounds();
    const auto in = [&](std::uint64_t k) -> Vector3d {
        const Vector3d share(u01(seed, k, 1), u01(seed, k, 2), u01(seed, k, 3));
        return box.min + (1.4 * share.array() - 0.2).matrix().cwiseProduct(box.max - box.min);
    };
    const auto corner = [&](std::uint64_t k) -> Vector3d {
        return (in(k) / map.resolution()).array().round() * map.resolution();
    };
    const Vector3d along = Vector3d::Unit(int(seed / 8 % 3));
    switch (seed % 8) {
    case 0:
        return {in(0) + 20 * along, in(0) - 20 * along};
    case 1:
        return {corner(0) + 20 * along, corner(0) - 20 * along};
    case 2:
        return {corner(0), corner(1)};
    case 3:
        return {corner(0), corner(0)};
    case 4:
        return {in(0), in(0) + 0.3 * (in(1) - in(2)).normalized()};
    case 5:
        return {corner(0), corner(0) + 0.5 * along};
    case 6:
        return {in(0) + 1e4 * (in(1) - in(2)), in(0) - 1e4 * (in(1) - in(2))};
    default:
        return {in(0), in(1)};
    }
}

TEST(MapWalk, TakesEveryCubeThatTheSegmentMeets)
{
    const Eigen::Vector3i corners[] = {{0, 0, 0}, {-8, -8, -8}, {-32768, -32768, -32768}, {32752, 100, -16}, {3, 5, 7}};
    int meetings = 0, taken_ones = 0;
    for (const Eigen::Vector3i& corner : corners)
        for (const int cubes : {1, 12, 150})
            for (const bool unknown_is_occupied : {false, true}) {
                const OccupancyMap map = make(corner, 16, cubes, unknown_is_occupied, std::uint64_t(cubes));
                const MapTree tree(map);
                SegmentWalk<MapTree> walk;
                std::vector<MapCell> all;
                map.each_cell(map.bounds(), [&](const MapCell& cell) { return all.push_back(cell), true; });
                for (std::uint64_t seed = 0; seed < 160; ++seed) {
                    SCOPED_TRACE(fmt::format("{} cubes at {}, unknown occupied: {}, seed {}", cubes, corner.x(),
                                             unknown_is_occupied, seed));
                    const Segment segment = segment_in(map, seed);
                    std::vector<MapCell> taken;
                    walk.walk(tree, segment, [&](const MapCell& cell) { return taken.push_back(cell), 1.0; });
                    const auto of = [](const MapCell& c) { return CellBox(c); };
                    for (const MapCell& cell : all) {
                        if (!segment_meets(segment, map.box(cell))) continue;
                        ++meetings;
                        const auto around = [&](const MapCell& t) { return of(t).contains(of(cell)); };
                        EXPECT_EQ(std::ranges::count_if(taken, around), 1)
                            << "cell " << cell.x << ' ' << cell.y << ' ' << cell.z << ' ' << cell.side;
                    }
                    taken_ones += int(taken.size());
                }
            }
    EXPECT_GT(meetings, 5000);
    EXPECT_LT(taken_ones, 2 * meetings);
}

} // namespace
} // namespace oncollide::map_walk_test
