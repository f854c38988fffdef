// Files of heights: reading, and refusing.
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/scenes/files/geometry_file.hpp>

#include "load_with_samples.hpp"
#include "scenes/same_scene.hpp"
#include "scenes/test_files.hpp"

namespace oncollide {
namespace {

using test::expect_error;
using test::expect_same_scene;
using test::TemporaryFolder;

const std::vector<double> six{0, 1, 2, 300, 4, 5}; // two rows of three

template <class Number>
std::string packed(const std::vector<double>& values, bool big)
{
    std::string bytes;
    for (const double value : values) {
        auto of = std::bit_cast<std::array<char, sizeof(Number)>>(static_cast<Number>(value));
        if (big) std::reverse(of.begin(), of.end());
        bytes.append(of.begin(), of.end());
    }
    return bytes;
}

std::string npy(std::string_view descr, bool fortran, std::string_view shape, const std::string& data, int version = 1)
{
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}\n", descr,
                                     fortran ? "True" : "False", shape);
    std::string bytes = "\x93NUMPY";
    bytes += char(version), bytes += '\0';
    bytes += char(header.size()), bytes += '\0';
    if (version > 1) bytes.append(2, '\0');
    return bytes + header + data;
}

void expect_six(const Terrain& terrain, double scale = 1)
{
    ASSERT_EQ(terrain.columns(), 3u);
    ASSERT_EQ(terrain.rows(), 2u);
    EXPECT_EQ(terrain.error(), 0);
    for (std::uint32_t i = 0; i < 6; ++i) EXPECT_EQ(terrain.height(i % 3, i / 3), scale * six[i]) << i;
}

TEST(TerrainFile, ReadsPgm)
{
    const TemporaryFolder folder;
    expect_six(load_terrain(folder.write("a.pgm", "P5\n# comment\n3 2\n65535\n" + packed<std::uint16_t>(six, true))));
    const Terrain eight =
        load_terrain(folder.write("b.PGM", std::string("P5 2 2 255\n\0\1\2\377", 15)), {.vertical_scale = 0.1});
    EXPECT_EQ(eight.height(1, 1), 25.5);
    EXPECT_EQ(eight.error(), 0);
    EXPECT_EQ(eight.bytes_per_height(), 2);
}

TEST(TerrainFile, ReadsNumPyArraysOfAllKinds)
{
    const TemporaryFolder folder;
    const auto expect = [&](const std::string& bytes) { expect_six(load_terrain(folder.write("a.npy", bytes))); };
    for (const bool big : {false, true}) {
        const char order = big ? '>' : '<';
        const auto type = [&](const char* rest) { return order + std::string(rest); };
        expect(npy(type("i2"), false, "(2, 3)", packed<std::int16_t>(six, big)));
        expect(npy(type("u2"), false, "(2, 3)", packed<std::uint16_t>(six, big), 2));
        expect(npy(type("i4"), false, "(2,3)", packed<std::int32_t>(six, big), 3));
        expect(npy(type("f4"), false, "(2, 3)", packed<float>(six, big)));
        expect(npy(type("f8"), false, "(2, 3)", packed<double>(six, big)));
        expect(npy(type("f8"), true, "(2, 3)", packed<double>({0, 300, 1, 4, 2, 5}, big)));
    }
    const Terrain bytes = load_terrain(folder.write("b.npy", npy("|u1", false, "(2, 2)", "\1\2\3\377")));
    EXPECT_EQ(bytes.height(1, 1), 255);
}

TEST(TerrainFile, ReadsRawArrays)
{
    const TemporaryFolder folder;
    TerrainOptions options{.columns = 3, .rows = 2, .type = ">i2"};
    expect_six(load_terrain(folder.write("a.raw", packed<std::int16_t>(six, true)), options));
    options.type = "<f8", options.vertical_scale = 0.5, options.spacing = Eigen::Vector2d(2, 3);
    const Terrain terrain = load_terrain(folder.write("a.bin", packed<double>(six, false)), options);
    expect_six(terrain, 0.5);
    EXPECT_EQ(terrain.bounds().max, Eigen::Vector3d(4, 3, 150));
    options.centre = true;
    EXPECT_EQ(load_terrain(folder.path() / "a.bin", options).bounds().min, Eigen::Vector3d(-2, -1.5, -75));
    options.columns = 4;
    expect_error(
        ErrorKind::bad_data, [&] { load_terrain(folder.path() / "a.bin", options); }, "a.bin: ", "4 x 2", "48 bytes");
    expect_error(
        ErrorKind::usage, [&] { load_terrain(folder.path() / "a.bin"); }, "a.bin: ", "columns, rows and type");
}

/// 3 x 2 grey, 16 bits, and 2 x 2, 8 bits: made with Python's zlib.
std::string from_hex(std::string_view hex)
{
    std::string bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
    return bytes;
}
constexpr const char* png16 = "89504e470d0a1a0a0000000d4948445200000003000000021000000000e88fe5850000001649444154789c63"
                              "6060606064606260d4616061600500011b003a16a31ee20000000049454e44ae426082";
constexpr const char* png8 = "89504e470d0a1a0a0000000d494844520000000200000002080000000057dd52f80000000e49444154789c636"
                             "0606460fa0f00010d0103d67c8ba80000000049454e44ae426082";
constexpr const char* png_interlaced =
    "89504e470d0a1a0a0000000d49484452000000030000000210000000019f88d513000000164944415478da63"
    "6000022606064606461d06160656000121003aacef30d00000000049454e44ae426082";
/// png16 with the chunks gAMA and zTXt.
constexpr const char* png_more =
    "89504e470d0a1a0a0000000d4948445200000003000000021000000000e88fe5850000000467414d41000000"
    "01fc2250db0000001d7a54587461000078daedc13101000000c2a0f54f6d0d0fa000008077030bb80001b13d"
    "bd520000001649444154789c636060606064606260d4616061600500011b003a16a31ee20000000049454e44"
    "ae426082";
constexpr const char* png_colour = "89504e470d0a1a0a0000000d4948445200000002000000020802000000fdd49a730000000b494441547"
                                   "89c6360400600000e0001a99173b10000000049454e44ae426082";
constexpr const char* png_large = "89504e470d0a1a0a0000000d49484452000186a0000186a01000000000dda988570000000b4944415478"
                                  "9c6360800100000a00017f80745e0000000049454e44ae426082";

TEST(TerrainFile, ReadsGreyPng)
{
    const TemporaryFolder folder;
    const auto file = folder.write("a.png", from_hex(png16));
    expect_six(load_terrain(file));
    EXPECT_EQ(load_terrain(folder.write("b.png", from_hex(png8))).height(1, 1), 255);
    expect_six(load_terrain(folder.write("i.png", from_hex(png_interlaced))));
    expect_six(load_terrain(folder.write("m.png", from_hex(png_more))));
    expect_error(
        ErrorKind::bad_data, [&] { load_terrain(folder.write("c.png", from_hex(png_colour))); },
        "c.png: ", "colour type 2");
    expect_error(
        ErrorKind::bad_data, [&] { load_terrain(folder.write("d.png", from_hex(png_large))); },
        "d.png: ", "100000 x 100000 heights are announced");
    for (const std::string& whole : {from_hex(png16), from_hex(png_more)}) {
        for (std::size_t length = 1; length < whole.size(); ++length)
            expect_error(
                ErrorKind::bad_data, [&] { load_terrain(folder.write("e.png", whole.substr(0, length))); }, "e.png: ");
        for (std::size_t at = 0; at < whole.size(); ++at) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
            expect_error(
                ErrorKind::bad_data, [&] { load_terrain(folder.write("f.png", damaged)); }, "f.png: ");
        }
    }
}

/// Its first row is the northernmost.
TEST(TerrainFile, ReadsWithGdalOrSaysWhatToInstall)
{
    const TemporaryFolder folder;
    const auto file = folder.write("a.asc", "ncols 3\nnrows 2\nxllcorner 5\nyllcorner 6\ncellsize 10\n"
                                            "NODATA_value -9999\n300 4 5\n0 1 2\n");
    try {
        const Terrain terrain = load_terrain(file);
        expect_six(terrain);
        EXPECT_EQ(terrain.spacing(), Eigen::Vector2d(10, 10));
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage);
        for (const char* cure : {"libgdal-dev", "cmake --preset release -DONCOLLIDE_GDAL=ON"})
            EXPECT_NE(std::string(error.what()).find(cure), std::string::npos) << error.what();
        return;
    }
    const auto refused = [&](const char* name, const char* text, auto... parts) {
        expect_error(
            ErrorKind::bad_data, [&] { load_terrain(folder.write(name, text)); }, name, parts...);
    };
    refused("b.asc", "ncols 3\nnrows 2\n", "GDAL cannot read");
    refused("c.asc", "ncols 100000\nnrows 100000\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 1 2\n", "");
    refused("d.tif", "II*", "GDAL cannot read");
    refused("e.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value 3\n3 3\n3 3\n", "hole");
}

TEST(TerrainFile, KnowsHoles)
{
    const TemporaryFolder folder;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> nine{-1, 1, 2, 3, 4, 5, 6, 7, nan};
    const std::string bytes = npy("<f8", false, "(3, 3)", packed<double>(nine, false));
    const auto file = folder.write("a.npy", bytes);
    expect_error(
        ErrorKind::bad_data, [&] { load_terrain(file); }, "a.npy: ", "column 2, row 2", "nan");
    expect_error(
        ErrorKind::bad_data, [&] { load_terrain(file, {.no_data = -1}); }, "a.npy: ", "not a number");
    EXPECT_EQ(load_terrain(file, {.no_data = nan}).cells(), 3u);
    const auto whole = folder.write("b.npy", npy("<f8", false, "(2, 3)", packed<double>({-1, 1, 2, 3, 4, 5}, false)));
    EXPECT_EQ(load_terrain(whole, {.vertical_scale = 0.1, .no_data = -1}).cells(), 1u);
    const auto none = folder.write("c.npy", npy("<f8", false, "(2, 2)", packed<double>({5, 5, 5, 5}, false)));
    expect_error(
        ErrorKind::bad_data, [&] { load_terrain(none, {.no_data = 5}); }, "c.npy: ", "every height is a hole");
}

TEST(TerrainFile, RefusesWhatIsNotWhole)
{
    const TemporaryFolder folder;
    const auto refused = [&](const char* file, const std::string& bytes, auto... parts) {
        expect_error(
            ErrorKind::bad_data, [&] { load_terrain(folder.write(file, bytes)); }, file, parts...);
    };
    refused("a.pgm", "P6 2 2 255\n....", "'P5'");
    refused("a.pgm", "P5", "no width");
    refused("a.pgm", "P5 2 2 255", "ends within the header");
    refused("a.pgm", "P5 2 2 70000\n", "70000");
    refused("a.pgm", "P5 2 2 255\n...", "3 bytes for them");
    refused("a.pgm", "P5 100000 100000 65535\n....", "100000 x 100000 heights");
    refused("a.pgm", "P5 4294967295 4294967295 65535\n....", "heights of 2 bytes are announced");
    refused("a.pgm", "P5 99999999999 2 255\n....", "no width");
    refused("a.pgm", "P5 1 4 255\n....", "at least two columns");
    refused("a.npy", "\x93NUMPX\x01", "must begin with");
    refused("a.npy", "\x93NUMPY\x01", "ends within the header");
    refused("a.npy", std::string("\x93NUMPY\x01\0\xff\xff", 10), "ends within the header");
    refused("a.npy", std::string("\x93NUMPY\x04\0\1\0", 10), "version 4");
    const std::string data = packed<double>(six, false);
    refused("a.npy", npy("<f8", false, "(100000, 100000)", data), "100000 x 100000");
    refused("a.npy", npy("<f8", false, "(6,)", data), "(6,)");
    refused("a.npy", npy("<f8", false, "(1, 2, 3)", data), "(1, 2, 3)");
    refused("a.npy", npy("<f8", false, "(-2, 3)", data), "two numbers");
    refused("a.npy", npy("<c16", false, "(2, 3)", data), "<c16");
    refused("a.npy", npy("<f8", false, "(2, 3)", data.substr(1)), "47 bytes");
    refused("a.npy", npy("<f8", false, "(1, 6)", data), "at least two");
    refused("a.xyz", "0 0 0\n", "unknown kind of terrain file '.xyz'");
    const std::string whole = npy("<f8", false, "(2, 3)", data);
    for (std::size_t length = 1; length < whole.size(); ++length) refused("b.npy", whole.substr(0, length));
    expect_error(
        ErrorKind::no_input, [&] { load_terrain(folder.path() / "missing.pgm"); }, "no such file");
    expect_error(
        ErrorKind::no_input, [&] { load_terrain(folder.path() / "missing.tif"); }, "no such file");
    expect_error(
        ErrorKind::usage, [&] { load_terrain(folder.path() / "a.npy", {.vertical_scale = 0}); }, "scale");
}

TEST(TerrainFile, SceneFilesHaveTerrains)
{
    const TemporaryFolder folder;
    folder.write("hill.npy", npy("<i2", false, "(2, 3)", packed<std::int16_t>(six, false)));
    const auto file = folder.write("scene.json", R"({"geometries": {
        "hill": {"terrain": {"file": "hill.npy", "spacing": [10, 20], "vertical_scale": 0.5, "no_data": 300, "diagonal": "falling"}},
        "hills": {"terrain": {"hills": {"cells": [20, 10], "spacing": 5, "height": 30, "seed": 4}}}},
        "bodies": [{"geometry": "hill", "static": true}, {"geometry": "hills"}]})");
    Scene scene = test::load_with_samples(file);
    const auto& hill = std::get<Terrain>(scene.geometries[0].data);
    EXPECT_EQ(hill.cells(), 1u);
    EXPECT_EQ(hill.spacing(), Eigen::Vector2d(10, 20));
    EXPECT_EQ(hill.height(2, 1), 2.5);
    EXPECT_EQ(hill.diagonal(0, 0), CellDiagonal::falling);
    EXPECT_EQ(std::get<Terrain>(scene.geometries[1].data).cells(), 200u);

    // Made in code: the heights go to a file beside the scene file.
    TerrainGrid grid{.columns = 3, .rows = 2};
    grid.no_data = 300, grid.falling = {true, false}, grid.spacing = {0.3, 0.7}, grid.origin = {1, 2, 3},
    grid.error = 0.25;
    scene.add("made", make_terrain("made", grid, six));
    save_scene(scene, folder.path() / "again.json");
    Scene again = test::load_with_samples(folder.path() / "again.json");
    expect_same_scene(scene, again);
    const auto wrong = [&](const char* entry, auto... parts) {
        const auto bad = folder.write(
            "bad.json", fmt::format(R"({{"geometries": {{"g": {{"terrain": {}}}}}, "bodies": []}})", entry));
        expect_error(
            ErrorKind::bad_data, [&] { test::load_with_samples(bad); }, "bad.json: geometries.g.terrain", parts...);
    };
    wrong(R"({"file": "hill.npy", "bytes": 3})", "3 bytes");
    wrong(R"({"file": "hill.npy", "no_data": "none"})", "no_data");
    wrong(R"({"file": "hill.npy", "diagonal": "up"})", "rising");
    wrong(R"({"file": "hill.npy", "height": 3})", "unknown key");
    wrong(R"({"hills": {"cells": [20000, 501], "spacing": 1, "height": 1}})", "10000000 in all");
    wrong(R"({"hills": {"cells": 30000, "spacing": 1, "height": 1}})", "cells");
}

} // namespace
} // namespace oncollide
