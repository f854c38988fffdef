#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "scenes/map_cells.hpp"
#include <oncollide/scenes/motion.hpp>

namespace oncollide::map_test {
namespace {

TEST(OccupancyMap, ABuildingHasCellsOfItsResolutionInItsBounds)
{
    const OccupancyMap map = make_building_map(3, 0.1, 1);
    EXPECT_EQ(map.resolution(), 0.1);
    EXPECT_GT(map.count(), 1000u);
    Aabb bounds;
    double volume = 0;
    for (const Aabb& cell : cells_of(map)) {
        const Vector3d side = (cell.max - cell.min) / 0.1;
        EXPECT_NEAR(side.x(), side.y(), 1e-9);
        EXPECT_NEAR(side.x(), side.z(), 1e-9);
        EXPECT_NEAR(std::log2(side.x()), std::round(std::log2(side.x())), 1e-9) << "a power of two";
        bounds.add(cell), volume += cell.volume();
    }
    EXPECT_EQ(bounds.min, map.bounds().min);
    EXPECT_EQ(bounds.max, map.bounds().max);
    EXPECT_NEAR(bounds.max.x() - bounds.min.x(), 12.1, 1e-9);
    EXPECT_LT(volume, 0.5 * bounds.volume()) << "rooms are mostly air";
    EXPECT_GT(volume, 12 * 12 * 0.1) << "at least the floor";
}

TEST(OccupancyMap, IsMadeOfCubesOfCells)
{
    const std::vector<MapCell> occupied{{0, 0, 0, 2}, {-32768, 5, 5, 1}, {32767, 5, 5, 1}}, free{{1, 1, 1, 1}};
    const OccupancyMap map = make_occupancy_map("map", 0.5, occupied, free);
    EXPECT_EQ(map.count(), 9u);
    EXPECT_EQ(map.bounds().min, Vector3d(-16384, 0, 0));
    EXPECT_EQ(map.bounds().max, Vector3d(16384, 3, 3));
    OccupancyMap copy = map;
    copy.set(Aabb{{0, 0, 0}, {1, 1, 1}}, CellState::free);
    EXPECT_EQ(copy.count(), 2u);
    EXPECT_EQ(map.count(), 9u) << "a copy has cells of its own";
}

TEST(OccupancyMap, OfCubesMayCountUnknownCellsAsOccupied)
{
    const MapCell occupied{0, 0, 0, 1}, free{3, 0, 0, 1};
    const OccupancyMap map = make_occupancy_map("map", 1, {&occupied, 1}, {&free, 1}, true);
    EXPECT_EQ(map.bounds().max, Vector3d(4, 1, 1));
    double volume = 0;
    for (const Aabb& cell : cells_of(map)) volume += cell.volume();
    EXPECT_EQ(volume, 3) << "all except the free cell";
}

TEST(OccupancyMap, CubesOfCellsOutsideTheGridAreRefused)
{
    constexpr std::int32_t far = std::numeric_limits<std::int32_t>::max();
    for (const MapCell& cube : {MapCell{32767, 0, 0, 2}, {0, -32769, 0, 1}, {0, 0, far, far}, {0, 0, 0, 0}})
        expect_error(
            ErrorKind::usage,
            [&] {
                make_occupancy_map("map", 1, {&cube, 1});
            },
            "map: the cube", "grid");
    expect_error(
        ErrorKind::bad_data, [] { make_occupancy_map("map", 1, {}); }, "map: no cell");
    const MapCell cell{0, 0, 0, 1};
    expect_error(
        ErrorKind::bad_data,
        [&] {
            make_occupancy_map("map", 0, {&cell, 1});
        },
        "map: the resolution");
}

TEST(OccupancyMap, CellsDoNotOverlapAndShareTheirFacesExactly)
{
    const std::vector<Aabb> cells = cells_of(make_building_map(1, 0.3, 1));
    int neighbours = 0;
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Vector3d low = cells[i].min.cwiseMax(cells[j].min), high = cells[i].max.cwiseMin(cells[j].max);
            ASSERT_FALSE((low.array() < high.array()).all());
            neighbours += (low.array() <= high.array()).all();
        }
    EXPECT_GT(neighbours, 100);
}

TEST(OccupancyMap, BuildingsAreDeterministicByTheirSeed)
{
    const OccupancyMap map = make_building_map(2, 0.2, 5);
    expect_equal(map, make_building_map(2, 0.2, 5));
    const OccupancyMap other = make_building_map(2, 0.2, 6);
    EXPECT_FALSE(std::ranges::equal(cells_of(map), cells_of(other),
                                    [](const Aabb& a, const Aabb& b) { return a.min == b.min && a.max == b.max; }));
    for (const double resolution : {0.05, 0.33, 1.0}) EXPECT_GT(make_building_map(1, resolution, 1).count(), 0u);
}

TEST(OccupancyMap, ImpossibleBuildingsAreRefused)
{
    for (const auto& [rooms, resolution] : {std::pair{0, 0.1}, {101, 0.1}, {2, 0.0}, {2, -0.1}, {2, 2.0}, {50, 0.01}})
        expect_error(
            ErrorKind::usage, [rooms = rooms, resolution = resolution] { make_building_map(rooms, resolution, 1); },
            "building: ");
    expect_error(
        ErrorKind::usage, [&] { make_building_map(2, std::nan(""), 1); }, "resolution is nan");
}

/// Two adjacent occupied cells and a free cell; the occupied cells were free before.
octomap::OcTree small_tree(bool lazy = false)
{
    octomap::OcTree tree(0.5);
    const octomap::point3d a(0.25f, 0.25f, 0.25f), b(0.75f, 0.25f, 0.25f), c(9, 9, 9);
    for (const auto& place : {a, b, c}) tree.updateNode(place, false);
    for (const auto& place : {a, b}) tree.updateNode(place, true, lazy);
    return tree;
}

TEST(OccupancyMap, IsMadeOfAnOctreeInMemory)
{
    const octomap::OcTree tree = small_tree();
    const OccupancyMap copied = make_occupancy_map(tree);
    EXPECT_EQ(copied.resolution(), 0.5);
    ASSERT_EQ(copied.count(), 2u);
    EXPECT_EQ(copied.bounds().min, Vector3d::Zero());
    EXPECT_EQ(copied.bounds().max, Vector3d(1, 0.5, 0.5));
    const auto shared = std::make_shared<const octomap::OcTree>(tree);
    const OccupancyMap map = make_occupancy_map(shared);
    expect_equal(copied, map);
    const test::TemporaryFolder folder;
    save_octomap(map, folder.path() / "a.bt");
    expect_equal(map, load_octomap(folder.path() / "a.bt"));
}

TEST(OccupancyMap, RefusesOctreesInMemoryWithTheErrorsOfFiles)
{
    const auto refuses = [](const octomap::OcTree& tree, const char* what) {
        expect_error(
            ErrorKind::bad_data, [&] { make_occupancy_map(tree); }, "octree: ", what);
    };
    octomap::OcTree tree(0.5);
    refuses(tree, "the map is empty");
    tree.updateNode(octomap::point3d(9, 9, 9), false);
    refuses(tree, "no cell of the map is occupied");
    tree.setNodeValue(octomap::point3d(1, 1, 1), std::nanf(""));
    refuses(tree, "an occupancy is not finite");
    refuses(octomap::OcTree(1e-7), "the resolution is 1e-07; it must be from 1e-06 to 1000000 m");
    expect_error(
        ErrorKind::bad_data, [] { make_occupancy_map(nullptr); }, "octree: there is none");
}

TEST(OccupancyMap, DoesNotTrustInnerNodesThatLazyUpdatesLeftBehind)
{
    const auto lazy = std::make_shared<const octomap::OcTree>(small_tree(true));
    const OccupancyMap map = make_occupancy_map(lazy);
    expect_equal(map, make_occupancy_map(*lazy));
    expect_equal(map, make_occupancy_map(small_tree()));
    // A file may contain such a tree too.
    std::ostringstream nodes;
    lazy->writeData(nodes);
    const test::TemporaryFolder folder;
    expect_equal(
        map, load_octomap(folder.write("a.ot", "# Octomap OcTree file\nid OcTree\nsize " +
                                                   std::to_string(lazy->size()) + "\nres 0.5\ndata\n" + nodes.str())));
}

octomap::OcTree drawn_tree(std::uint64_t seed)
{
    octomap::OcTree tree(0.5);
    for (std::uint64_t i = 0; i < 60; ++i) {
        const auto at = [&](std::uint64_t k) { return float(std::floor(u01(seed, i, k) * 16) - 8) / 2 + 0.25f; };
        const octomap::point3d corner(at(0), at(1), at(2));
        const bool occupied = u01(seed, i, 3) < 0.5;
        const int side = 1 + 3 * int(i % 3 == 0);
        for (int k = 0; k < side * side * side; ++k)
            tree.setNodeValue(
                corner + octomap::point3d(float(k % side), float(k / side % side), float(k / side / side)) * 0.5f,
                occupied ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog());
    }
    tree.updateInnerOccupancy();
    tree.prune();
    return tree;
}

std::string nodes_of(const std::string& file)
{
    return file.substr(file.find("data\n") + 5);
}

TEST(OccupancyMap, WritesAndMakesWhatOctoMapDoes)
{
    const test::TemporaryFolder folder;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const octomap::OcTree tree = drawn_tree(seed);
        const OccupancyMap map = make_occupancy_map(tree);
        save_octomap(map, folder.path() / "a.bt");
        std::ostringstream nodes;
        tree.writeBinaryData(nodes);
        const std::string written = bytes_of(folder.path() / "a.bt");
        EXPECT_EQ(nodes_of(written), nodes.str()) << seed;
        EXPECT_NE(written.find("size " + std::to_string(tree.calcNumNodes()) + "\n"), std::string::npos);
        const auto again = make_octree(map);
        EXPECT_TRUE(*again == tree) << seed;
        expect_equal(map, load_octomap(folder.path() / "a.bt"));
    }
}

TEST(OccupancyMap, ABinaryFileWhoseRootHasNoChildrenIsAllOccupiedAsOctoMapReadsIt)
{
    const test::TemporaryFolder folder;
    const std::string header = "# Octomap OcTree binary file\nid OcTree\nsize 1\nres 0.5\ndata\n";
    const OccupancyMap map = load_octomap(folder.write("a.bt", header + std::string(2, '\0')));
    octomap::OcTree tree(0.5);
    std::istringstream nodes(std::string(2, '\0'));
    tree.readBinaryData(nodes);
    expect_equal(map, make_occupancy_map(tree));
    EXPECT_EQ(map.count(), 1u);
    EXPECT_EQ(map.bounds().min, Vector3d::Constant(-16384));
    EXPECT_EQ(map.bounds().max, Vector3d::Constant(16384));
    save_octomap(map, folder.path() / "b.bt");
    expect_equal(map, load_octomap(folder.path() / "b.bt"));
    EXPECT_EQ(make_octree(map)->calcNumNodes(), 1u);
}

TEST(OccupancyMap, UnknownCellsCanCountAsOccupiedWithinTheKnownBounds)
{
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const octomap::OcTree tree = drawn_tree(seed);
        const OccupancyMap map = make_occupancy_map(tree, true);
        double solid = 0, free = 0;
        Aabb known;
        for (const Aabb& cell : cells_of(map)) solid += cell.volume();
        for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
            const Vector3d centre(leaf.getX(), leaf.getY(), leaf.getZ());
            known.add(Aabb{centre.array() - leaf.getSize() / 2, centre.array() + leaf.getSize() / 2});
            if (!tree.isNodeOccupied(*leaf)) free += std::pow(leaf.getSize(), 3);
        }
        EXPECT_EQ(map.bounds().min, known.min);
        EXPECT_EQ(map.bounds().max, known.max);
        EXPECT_NEAR(solid, known.volume() - free, 1e-6) << seed;
    }
}

TEST(OccupancyMap, AFullFileTakesAThresholdOfOccupancy)
{
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.ot", chain_ot(16, 0.5f, 17)); // a probability of 0.62
    EXPECT_EQ(load_octomap(path, {.occupancy_threshold = 0.6}).count(), 1u);
    expect_error(
        ErrorKind::bad_data, [&] { load_octomap(path, {.occupancy_threshold = 0.7}); },
        "no cell of the map is occupied");
    for (const double threshold : {0.0, 1.0, -1.0, std::nan("")})
        expect_error(
            ErrorKind::usage, [&] { load_octomap(path, {.occupancy_threshold = threshold}); }, "above 0 and below 1");
    save_octomap(make_building_map(1, 1, 5), folder.path() / "a.bt");
    expect_error(
        ErrorKind::usage, [&] { load_octomap(folder.path() / "a.bt", {.occupancy_threshold = 0.6}); },
        "has no probabilities");
}

TEST(OccupancyMap, TakesScansInAsOctoMapDoes)
{
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        octomap::OcTree tree = drawn_tree(seed);
        OccupancyMap map = make_occupancy_map(tree);
        for (std::uint64_t scan = 0; scan < 4; ++scan) {
            const auto number = [&](std::uint64_t i, std::uint64_t k) { return 10 * u01(seed, 100 * scan + i, k) - 5; };
            std::vector<Vector3d> points;
            octomap::Pointcloud cloud;
            for (std::uint64_t i = 0; i < 60; ++i) {
                points.emplace_back(number(i, 0), number(i, 1), number(i, 2));
                cloud.push_back(float(points[i].x()), float(points[i].y()), float(points[i].z()));
            }
            const Vector3d origin(number(99, 0), number(99, 1), number(99, 2));
            map.insert_scan(points, origin, 4);
            tree.insertPointCloud(cloud, {float(origin.x()), float(origin.y()), float(origin.z())}, 4);
            expect_equal(map, make_occupancy_map(tree));
            // Cells that are set between scans are certain from then on.
            const Aabb box{Vector3d::Constant(-0.5 * double(scan)), Vector3d::Constant(2)};
            map.set(box, scan % 2 ? CellState::occupied : CellState::free);
            for (double x = box.min.x() + 0.25; x < 2; x += 0.5)
                for (double y = box.min.y() + 0.25; y < 2; y += 0.5)
                    for (double z = box.min.z() + 0.25; z < 2; z += 0.5) {
                        const octomap::point3d p{float(x), float(y), float(z)};
                        tree.setNodeValue(p, scan % 2 ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog());
                    }
            expect_equal(map, make_occupancy_map(tree));
        }
    }
}

} // namespace
} // namespace oncollide::map_test
