#include <oncollide/base/random.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "test_files.hpp"
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

std::string bytes_of(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void expect_equal(const OccupancyMap& a, const OccupancyMap& b)
{
    EXPECT_EQ(a.resolution, b.resolution);
    ASSERT_EQ(a.cells.size(), b.cells.size());
    for (std::size_t i = 0; i < a.cells.size(); ++i) {
        ASSERT_EQ(a.cells[i].min, b.cells[i].min);
        ASSERT_EQ(a.cells[i].max, b.cells[i].max);
    }
}

/// A `.ot` file: one path from the root to `depth` by first children, the last node with that log-odds.
std::string chain_ot(int depth, float log_odds, int size)
{
    std::string bytes = "# Octomap OcTree file\nid OcTree\nsize " + std::to_string(size) + "\nres 0.5\ndata\n";
    for (int level = 0; level <= depth; ++level) {
        bytes.append(reinterpret_cast<const char*>(&log_odds), 4);
        bytes += level < depth ? '\1' : '\0';
    }
    return bytes;
}

TEST(OccupancyMap, ABuildingHasCellsOfItsResolutionInItsBounds)
{
    const OccupancyMap map = make_building_map(3, 0.1, 1);
    EXPECT_EQ(map.resolution, 0.1);
    EXPECT_GT(map.cells.size(), 1000u);
    Aabb bounds;
    double volume = 0;
    for (const Aabb& cell : map.cells) {
        const Vector3d side = (cell.max - cell.min) / 0.1;
        EXPECT_NEAR(side.x(), side.y(), 1e-9);
        EXPECT_NEAR(side.x(), side.z(), 1e-9);
        EXPECT_NEAR(std::log2(side.x()), std::round(std::log2(side.x())), 1e-9) << "a power of two";
        bounds.add(cell), volume += cell.volume();
    }
    EXPECT_EQ(bounds.min, map.bounds.min);
    EXPECT_EQ(bounds.max, map.bounds.max);
    EXPECT_NEAR(bounds.max.x() - bounds.min.x(), 12.1, 1e-9);
    EXPECT_LT(volume, 0.5 * bounds.volume()) << "rooms are mostly air";
    EXPECT_GT(volume, 12 * 12 * 0.1) << "at least the floor";
}

TEST(OccupancyMap, CellsDoNotOverlapAndShareTheirFacesExactly)
{
    const OccupancyMap map = make_building_map(1, 0.3, 1);
    int neighbours = 0;
    for (std::size_t i = 0; i < map.cells.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Vector3d low = map.cells[i].min.cwiseMax(map.cells[j].min),
                           high = map.cells[i].max.cwiseMin(map.cells[j].max);
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
    EXPECT_FALSE(map.cells.size() == other.cells.size() &&
                 std::equal(map.cells.begin(), map.cells.end(), other.cells.begin(),
                            [](const Aabb& a, const Aabb& b) { return a.min == b.min && a.max == b.max; }));
    for (const double resolution : {0.05, 0.33, 1.0}) EXPECT_FALSE(make_building_map(1, resolution, 1).cells.empty());
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

TEST(OccupancyMap, ASavedMapLoadsBackWithEqualCells)
{
    const test::TemporaryFolder folder;
    const OccupancyMap map = make_building_map(2, 0.2, 5);
    save_octomap(map, folder.path() / "a.bt");
    expect_equal(map, load_octomap(folder.path() / "a.bt"));
    const OccupancyMap odd = make_building_map(1, 1.0 / 3, 5);
    save_octomap(odd, folder.path() / "a.bt");
    expect_equal(odd, load_octomap(folder.path() / "a.bt"));
    save_octomap(map, folder.path() / "a.bt"); // over the old file
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "no temporary file stays";
}

TEST(OccupancyMap, WhatCannotBeWrittenLeavesNothingBehind)
{
    const test::TemporaryFolder folder;
    const OccupancyMap map = make_building_map(1, 1, 5);
    expect_error(
        ErrorKind::cannot_write, [&] { save_octomap(map, folder.path() / "missing" / "a.bt"); },
        "a.bt: cannot write: there is no folder");
    std::filesystem::create_directories(folder.path() / "taken.bt" / "full");
    expect_error(
        ErrorKind::cannot_write, [&] { save_octomap(map, folder.path() / "taken.bt"); }, "taken.bt");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(OccupancyMap, FullFilesAreReadToo)
{
    const test::TemporaryFolder folder;
    const OccupancyMap map = load_octomap(folder.write("a.ot", chain_ot(16, 2.0f, 17)));
    ASSERT_EQ(map.cells.size(), 1u);
    EXPECT_EQ(map.cells[0].min, Vector3d::Constant(-16384));
    EXPECT_EQ(map.cells[0].max, Vector3d::Constant(-16383.5));
    const OccupancyMap coarse = load_octomap(folder.write("b.ot", chain_ot(1, 2.0f, 2)));
    EXPECT_EQ(coarse.bounds.min, Vector3d::Constant(-16384));
    EXPECT_EQ(coarse.bounds.max, Vector3d::Zero());
}

/// Two occupied cells beside each other and a free one; the occupied ones have been free before.
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
    EXPECT_EQ(copied.resolution, 0.5);
    ASSERT_EQ(copied.cells.size(), 2u);
    EXPECT_EQ(copied.bounds.min, Vector3d::Zero());
    EXPECT_EQ(copied.bounds.max, Vector3d(1, 0.5, 0.5));
    const auto shared = std::make_shared<const octomap::OcTree>(tree);
    const OccupancyMap map = make_occupancy_map(shared);
    expect_equal(copied, map);
    EXPECT_EQ(map.tree, shared);
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
    expect_error(
        ErrorKind::bad_data, [&] { make_occupancy_map(lazy); }, "octree: ", "updateInnerOccupancy()");
    const OccupancyMap map = make_occupancy_map(*lazy); // a copy can be brought up to date
    EXPECT_TRUE(map.tree->isNodeOccupied(map.tree->getRoot()));
    expect_equal(map, make_occupancy_map(small_tree()));
    // A file may hold such a tree too.
    std::ostringstream nodes;
    lazy->writeData(nodes);
    const test::TemporaryFolder folder;
    const OccupancyMap read =
        load_octomap(folder.write("a.ot", "# Octomap OcTree file\nid OcTree\nsize " + std::to_string(lazy->size()) +
                                              "\nres 0.5\ndata\n" + nodes.str()));
    EXPECT_TRUE(read.tree->isNodeOccupied(read.tree->getRoot()));
    expect_equal(map, read);
}

TEST(OccupancyMap, BadFilesAreRefusedInSilence)
{
    const test::TemporaryFolder folder;
    save_octomap(make_building_map(1, 0.5, 5), folder.path() / "good.bt");
    const std::string good = bytes_of(folder.path() / "good.bt");
    testing::internal::CaptureStderr();
    const auto bad = [&](const std::string& name, const std::string& bytes, const char* part) {
        const auto path = folder.write(name, bytes);
        expect_error(
            ErrorKind::bad_data, [&] { load_octomap(path); }, path.string() + ": ", part);
    };
    for (std::size_t size = 1; size < good.size(); size += size < 200 ? 1 : 37) bad("a.bt", good.substr(0, size), "");
    bad("a.bt", good.substr(0, good.size() - 1), "truncated");
    bad("a.bt", good + '\0', "1 bytes follow");
    bad("a.bt", "", "empty");
    bad("a.bt", std::string(1000, '\xff'), "not an OctoMap");
    bad("a.bt", good.substr(0, good.find("data\n") + 5) + std::string(100000, '\xff'), "deeper than 16");
    bad("a.bt", chain_ot(16, 2.0f, 17), "not an OctoMap");
    bad("a.xyz", good, "known are bt, ot");
    bad("a.ot", chain_ot(16, 2.0f, 18), "announces 18 nodes, but there are 17");
    bad("a.ot", chain_ot(17, 2.0f, 18), "deeper than 16");
    bad("a.ot", chain_ot(16, -2.0f, 17), "no cell of the map is occupied");
    bad("a.ot", chain_ot(16, std::nanf(""), 17), "not finite");
    std::string other = good;
    bad("a.bt", other.replace(other.find("id OcTree"), 9, "id Colour"), "'Colour'");
    other = good;
    bad("a.bt", other.replace(other.find("res 0.5"), 7, "res nan"), "resolution");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    expect_error(
        ErrorKind::no_input, [&] { load_octomap(folder.path() / "missing.bt"); }, "no such file");
    expect_error(
        ErrorKind::no_input, [&] { load_octomap(folder.path()); }, "folder");
}

TEST(OccupancyMap, DamagedFilesGiveAnErrorOrAMap)
{
    const test::TemporaryFolder folder;
    save_octomap(make_building_map(1, 0.5, 5), folder.path() / "good.bt");
    const std::string good = bytes_of(folder.path() / "good.bt");
    for (std::uint64_t round = 0; round < 300; ++round) {
        std::string bytes = good;
        for (std::uint64_t k = 0; k < 3; ++k)
            bytes[static_cast<std::size_t>(u01(3, round, k) * bytes.size())] =
                static_cast<char>(u01(3, round, k + 9) * 256);
        try {
            load_octomap(folder.write("a.bt", bytes));
        } catch (const Error& error) {
            EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(ErrorKind::bad_data)) << error.what();
        }
    }
}

TEST(OccupancyMap, ReadsAScannedBuilding)
{
    const auto data = test::data_folder();
    if (data.empty()) GTEST_SKIP() << "skipped: no data";
    const OccupancyMap map = load_octomap(data / "octomap/geb079.bt");
    EXPECT_EQ(map.resolution, 0.08);
    EXPECT_GT(map.cells.size(), 30000u);
    EXPECT_GT(map.bounds.diagonal(), 10);
    EXPECT_LT(map.bounds.diagonal(), 200) << "not the address space";
}

} // namespace
} // namespace oncollide
