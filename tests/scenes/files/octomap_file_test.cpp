// Maps in OctoMap's files.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "scenes/map_cells.hpp"

namespace oncollide::map_test {
namespace {

TEST(OccupancyMap, ASavedMapLoadsBackWithEqualCells)
{
    const test::TemporaryFolder folder;
    const OccupancyMap map = make_building_map(2, 0.2, 5);
    save_octomap(map, folder.path() / "a.bt");
    expect_equal(map, load_octomap(folder.path() / "a.bt"));
    const OccupancyMap odd = make_building_map(1, 1.0 / 3, 5);
    save_octomap(odd, folder.path() / "a.bt");
    expect_equal(odd, load_octomap(folder.path() / "a.bt"));
    save_octomap(map, folder.path() / "a.bt"); // replaces the old file
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
    ASSERT_EQ(map.count(), 1u);
    EXPECT_EQ(cells_of(map)[0].min, Vector3d::Constant(-16384));
    EXPECT_EQ(cells_of(map)[0].max, Vector3d::Constant(-16383.5));
    const OccupancyMap coarse = load_octomap(folder.write("b.ot", chain_ot(1, 2.0f, 2)));
    EXPECT_EQ(coarse.bounds().min, Vector3d::Constant(-16384));
    EXPECT_EQ(coarse.bounds().max, Vector3d::Zero());
}

TEST(OccupancyMap, ColouredMapsAndHeadersWithCrLfAreRead)
{
    const test::TemporaryFolder folder;
    const auto replaced = [](std::string text, std::string_view from, std::string_view to) {
        const std::size_t data = text.find("data\n") + 5;
        std::string header = text.substr(0, data);
        for (std::size_t at = 0; (at = header.find(from, at)) != header.npos; at += to.size())
            header.replace(at, from.size(), to);
        return header + text.substr(data);
    };
    const std::string plain = chain_ot(3, 2.0f, 4);
    const OccupancyMap map = load_octomap(folder.write("a.ot", plain));
    std::string coloured = plain.substr(0, plain.find("data\n") + 5);
    for (std::size_t at = coloured.size(); at < plain.size(); at += 5)
        coloured += plain.substr(at, 4) + "rgb" + plain.substr(at + 4, 1);
    coloured = replaced(coloured, "id OcTree", "id ColorOcTree");
    OccupancyMap of_colours = load_octomap(folder.write("b.ot", coloured));
    expect_equal(map, of_colours);
    of_colours.insert_scan(std::vector<Vector3d>{{1.25, 0.25, 0.25}}, {0.25, 0.25, 0.25});
    EXPECT_GT(of_colours.count(), map.count()) << "the probabilities are kept";
    expect_equal(map, load_octomap(folder.write("c.ot", replaced(plain, "\n", "\r\n"))));
    expect_equal(map, load_octomap(folder.write("d.ot", replaced(coloured, "\n", "\r\n"))));
    save_octomap(map, folder.path() / "e.bt");
    const std::string binary = bytes_of(folder.path() / "e.bt");
    expect_equal(map, load_octomap(folder.write("f.bt", replaced(binary, "\n", "\r\n"))));
    expect_equal(map, load_octomap(folder.write("g.bt", replaced(binary, "id OcTree", "id ColorOcTree"))));
    for (std::size_t size = coloured.size() - 8; size < coloured.size(); ++size)
        expect_error(
            ErrorKind::bad_data, [&] { load_octomap(folder.write("h.ot", coloured.substr(0, size))); }, "truncated");
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

/// Occupied, free and unknown cells; some of them joined.
TEST(OccupancyMap, AllocatesNothingForWhatAHeaderPromises)
{
    const test::TemporaryFolder folder;
    const auto file = [&](const char* nodes) {
        return folder.write("a.bt", std::string("# Octomap OcTree binary file\nid OcTree\nsize ") + nodes +
                                        "\nres 1\ndata\n" + std::string("\2\0", 2));
    };
    expect_error(
        ErrorKind::bad_data, [&] { load_octomap(file("20000000")); }, "announces 20000000 nodes, but there are 2");
    expect_error(
        ErrorKind::bad_data, [&] { load_octomap(file("20000001")); }, "at most 20000000 are allowed");
    expect_error(
        ErrorKind::bad_data, [&] { load_octomap(file("99999999999999999999")); }, "invalid header line");
    EXPECT_EQ(load_octomap(file("2")).count(), 1u);
}

TEST(OccupancyMap, ReadsAScannedBuildingOfTheDataFolder)
{
    const auto data = test::data_folder();
    if (data.empty()) GTEST_SKIP() << "skipped: no data";
    const OccupancyMap map = load_octomap(data / "octomap/geb079.bt");
    EXPECT_EQ(map.resolution(), 0.08);
    EXPECT_GT(map.count(), 30000u);
    EXPECT_GT(map.bounds().diagonal(), 10);
    EXPECT_LT(map.bounds().diagonal(), 200) << "not the address space";
}

} // namespace
} // namespace oncollide::map_test
