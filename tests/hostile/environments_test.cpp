// Invalid maps, terrains and shapes in scene files: each must give one line with the place and the valid values, and
// allocate no memory for sizes in a header.
#include <bit>
#include <limits>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

class HostileEnvironments : public CommandLine {
protected:
    /// Limits the run to that many MB of data and ten seconds.
    Outcome run_scene(const std::string& geometry, int megabytes = 60)
    {
        folder_.write("s.json", fmt::format(R"({{"geometries":{{"g":{},"ball":{{"shape":{{"kind":"sphere",)"
                                            R"("radius":1}}}}}},"bodies":[{{"geometry":"g"}},{{"geometry":"ball"}}]}})",
                                            geometry));
        return run_program(
            "/bin/sh",
            {"-c",
             fmt::format("ulimit -d {} && exec timeout 10 " ONCOLLIDE_COMMAND " run s.json --quiet", megabytes * 1024)},
            {.folder = folder_.path()});
    }
    void refused(const std::string& geometry, const std::vector<std::string>& words, int code = 65, int megabytes = 60)
    {
        SCOPED_TRACE(geometry.substr(0, 200));
        const Outcome outcome = run_scene(geometry, megabytes);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.err.starts_with("oncollide: s.json: ")) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        for (const std::string& word : words) EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    }
    void taken(const std::string& geometry)
    {
        const Outcome outcome = run_scene(geometry);
        EXPECT_EQ(outcome.code, 0) << geometry << outcome.err;
    }

    void map_refused(const std::string& bytes, const std::vector<std::string>& words, const char* ending = "bt")
    {
        const std::string name = std::string("map.") + ending;
        folder_.write(name, bytes);
        std::vector<std::string> all{"geometries.g.octomap.file: " + name + ": "};
        all.insert(all.end(), words.begin(), words.end());
        refused(fmt::format(R"({{"octomap":{{"file":"{}"}}}})", name), all);
    }
    static std::string bt(const std::string& size, const std::string& resolution, const std::string& nodes)
    {
        return fmt::format("# Octomap OcTree binary file\nid OcTree\nsize {}\nres {}\ndata\n{}", size, resolution,
                           nodes);
    }

    std::string terrain(const std::string& name, const std::string& bytes, const std::string& more = "")
    {
        folder_.write(name, bytes);
        return fmt::format(R"({{"terrain":{{"file":"{}"{}}}}})", name, more);
    }
    static std::string npy(const std::string& shape, const std::string& type, const std::string& data)
    {
        std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
        header.append(63 - (10 + header.size()) % 64, ' ').push_back('\n');
        return std::string("\x93NUMPY\x01\x00", 8) + char(header.size()) + '\0' + header + data;
    }
    static std::string doubles(const std::vector<double>& numbers)
    {
        std::string bytes;
        for (const double number : numbers)
            for (int i = 0; i < 8; ++i) bytes += char(std::bit_cast<std::uint64_t>(number) >> 8 * i & 0xff);
        return bytes;
    }
};

const std::string occupied("\x02\x00", 2); ///< one child of the root

TEST_F(HostileEnvironments, MapsThatAreCutOffOrOfNoSizeAreRefused)
{
    map_refused("", {"empty"});
    map_refused("# Octomap OcTree binary file\n", {"ends within the header"});
    map_refused(bt("2", "0.1", ""), {"truncated"});
    map_refused(bt("3", "0.1", "\x03"), {"truncated"});
    map_refused(bt("3", "0.1", occupied), {"announces 3 nodes", "there are 2"});
    map_refused(bt("2", "0.1", occupied + "more"), {"4 bytes follow"});
    map_refused(bt("0", "0.1", ""), {"the map is empty"});
    map_refused(bt("-1", "0.1", occupied), {"no size"});
    map_refused(bt("4000000000", "0.1", occupied), {"4000000000 nodes", "at most 20000000"});
    for (const char* resolution : {"0", "-1", "nan", "inf", "1e-7", "1e7", "1e400"})
        map_refused(bt("2", resolution, occupied), {"the resolution is", "from 1e-06 to 1000000 m"});
    for (const char* resolution : {"abc", ""})
        map_refused(bt("2", resolution, occupied), {"line 4", "invalid header line", "id, size, res, data"});
    map_refused(bt("9", "0.1", "\x55\x55"), {"no cell of the map is occupied"});
    std::string deep;
    for (int i = 0; i < 20; ++i) deep += std::string("\x03\x00", 2);
    map_refused(bt("20", "0.1", deep), {"deeper than 16 levels"});
    const auto ot = [](const char* size, const std::string& node) {
        return fmt::format("# Octomap OcTree file\nid OcTree\nsize {}\nres 0.1\ndata\n{}", size, node);
    };
    map_refused(ot("1", std::string("\x00\x00\x80\x7f\x00", 5)), {"not finite"}, "ot");
    map_refused(ot("1", std::string("\x00\x00\x80\xbf\x00", 5)), {"no cell", "occupied"}, "ot");
    map_refused(ot("2", std::string("\x00\x00\x80\x3f\xff", 5)), {"truncated"}, "ot");
    map_refused(ot("1000000000", std::string("\x00\x00\x80\x3f\x00", 5)), {"1000000000 nodes"}, "ot");
    refused(R"({"octomap":{"file":"none.bt"}})", {"none.bt: no such file"}, 66);
}

/// The whole grid, 6.5 km wide, is one cube.
TEST_F(HostileEnvironments, AMapThatIsAllOccupiedIsACube)
{
    for (const std::string& nodes : {std::string("\xaa\xaa"), std::string(2, '\0')}) {
        folder_.write("map.bt", bt(nodes[0] ? "9" : "1", "0.1", nodes));
        taken(R"({"octomap":{"file":"map.bt"}})");
        for (const std::vector<std::string>& more : {std::vector<std::string>{"--exact", "predicates"},
                                                     {"--depth", "6", "--bounding-volume", "sphere"},
                                                     {"--exact", "fcl"},
                                                     {"--exact", "predicates", "--mode", "solid"}}) {
            std::vector<std::string> command{"run", "s.json", "--quiet", "--json", "r.json"};
            command.insert(command.end(), more.begin(), more.end());
            const Outcome outcome = run(command);
            EXPECT_EQ(outcome.code, 0) << outcome.err;
            EXPECT_EQ(read_json("r.json")["frames"][0]["pairs"].size(), 1u);
        }
    }
}

TEST_F(HostileEnvironments, TerrainsWithHeightsThatAreNoneAreRefused)
{
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    const auto heights = [&](double odd) { return npy("(2, 3)", "<f8", doubles({0, 1, 2, 3, odd, 5})); };
    refused(terrain("t.npy", heights(nan)), {"geometries.g.terrain", "t.npy", "column 1, row 1 is nan", "no_data"});
    refused(terrain("t.npy", heights(nan), R"(,"no_data":-9999)"), {"not a number", "no-data value is -9999"});
    refused(terrain("t.npy", heights(inf)), {"column 1, row 1 is inf", "at most 1e+15"});
    refused(terrain("t.npy", heights(1e300)), {"column 1, row 1 is 1e+300"});
    const std::string holes = npy("(2, 3)", "<f8", doubles({-9, -9, -9, -9, -9, -9}));
    refused(terrain("t.npy", holes, R"(,"no_data":-9)"), {"every height is a hole"});
    refused(terrain("t.npy", heights(-9), R"(,"no_data":-9)"), {"no cell", "touches a hole"});
    taken(terrain("t.npy", heights(4)));
    for (const char* spacing : {"0", "-1", "[1,0]"})
        refused(terrain("t.npy", heights(4), fmt::format(R"(,"spacing":{})", spacing)), {"spacing", "above 0"});
    refused(terrain("t.npy", heights(4), R"(,"vertical_scale":1e300)"), {"vertical scale of 1e+300", "at most 1e15"});
    refused(terrain("t.npy", heights(4), R"(,"error":-1)"), {"error of heights is -1", "0 or more"});
    refused(terrain("t.npy", heights(4), R"(,"origin":[1e16,0,0])"), {"at most 1e+15 m"});
    refused(terrain("t.npy", heights(4), R"(,"bytes":3)"), {"heights of 3 bytes", "1, 2, 4 or 8"});
}

TEST_F(HostileEnvironments, TerrainsOfOneRowOrOfMoreThanTheFileHoldsAreRefused)
{
    const std::string few(1000, '\0');
    refused(terrain("t.npy", npy("(1, 4)", "<f8", std::string(32, '\0'))), {"4 x 1 heights", "at least two"});
    refused(terrain("t.npy", npy("(4, 1)", "<f8", std::string(32, '\0'))), {"1 x 4 heights", "at least two"});
    refused(terrain("t.npy", npy("(4,)", "<f8", std::string(32, '\0'))), {"(4,)", "two numbers"});
    refused(terrain("t.npy", npy("(0, 4)", "<f8", "")), {"4 x 0 heights", "at least two"});
    for (const char* type : {"<f8", "<f4", "|u1", ">i2"})
        refused(terrain("t.npy", npy("(100000, 100000)", type, few)), {"100000 x 100000", "1000 bytes"});
    refused(terrain("t.npy", npy("(10, 10)", "<f8", std::string(799, '\0'))), {"10 x 10", "799 bytes"});
    refused(terrain("t.npy", npy("(4294967296, 4294967296)", "<f8", few)), {"t.npy", "4294967296"});
    refused(terrain("t.npy", ""), {"t.npy", "empty"});
    refused(terrain("t.npy", "\x93NUMPY"), {"ends within the header"});
    refused(terrain("t.pgm", "P5\n100000 100000\n65535\n" + few), {"t.pgm", "100000 x 100000"});
    refused(terrain("t.pgm", "P5\n10 1\n255\n" + std::string(10, '\0')), {"10 x 1 heights"});
    refused(terrain("t.raw", few, R"(,"columns":100000,"rows":100000,"type":"<i2")"), {"t.raw", "1000 bytes"});
    refused(terrain("t.raw", few), {"t.raw", "columns, rows and type"});
    refused(R"({"terrain":{"hills":{"cells":[100000,100000],"spacing":1,"height":1,"seed":1}}})",
            {"hills.cells[0]", "from 1 to 20000"});
    refused(R"({"terrain":{"file":"none.npy"}})", {"none.npy: no such file"}, 66);
}

/// GDAL searched a short file for lines for minutes, and returned zeros for missing data.
TEST_F(HostileEnvironments, RastersOfGdalOfMoreThanTheirFilesHoldAreRefused)
{
    const auto grid = [](const char* counts) {
        return fmt::format("{}xllcorner 0\nyllcorner 0\ncellsize 1\n0 0 0\n", counts);
    };
    taken(R"({"shape":{"kind":"half_space"}})");
    const Outcome first = run_scene(terrain("t.asc", grid("ncols 2\nnrows 2\n") + "0\n"), 400);
    if (first.err.find("without GDAL") != std::string::npos) GTEST_SKIP() << "no GDAL";
    refused(terrain("t.asc", grid("ncols 100000\nnrows 100000\n")), {"t.asc", "100000 x 100000", "at most"}, 65, 400);
    refused(terrain("t.asc", grid("ncols 40000\nnrows 40000\n")), {"t.asc", "40000 x 40000", "bytes"}, 65, 400);
    refused(terrain("t.vrt", R"(<VRTDataset rasterXSize="20000" rasterYSize="20000"><VRTRasterBand )"
                             R"(dataType="Float32" band="1"></VRTRasterBand></VRTDataset>)"),
            {"t.vrt", "20000 x 20000", "bytes"}, 65, 400);
}

TEST_F(HostileEnvironments, ShapesWithoutASizeAreRefused)
{
    const std::vector<std::pair<std::string, std::string>> kinds{{"sphere", "radius"},   {"capsule", "radius"},
                                                                 {"cylinder", "length"}, {"cylinder", "radius"},
                                                                 {"cone", "radius"},     {"cone", "length"}};
    for (const auto& [kind, field] : kinds) {
        const std::string other = kind == "sphere" ? "" : field == "radius" ? R"(,"length":1)" : R"(,"radius":1)";
        const auto shape = [&](const std::string& value) {
            return fmt::format(R"({{"shape":{{"kind":"{}","{}":{}{}}}}})", kind, field, value, other);
        };
        for (const char* value : {"0", "-1", "1e16"})
            refused(shape(value), {"geometries.g.shape", field, "above 0 and at most"});
        for (const char* value : {"1e-320", "5e-324", "1e-61"})
            refused(shape(value), {"geometries.g.shape", field, "below 1e-60 m", "scale the scene up"});
        refused(shape("1e400"), {"geometries.g.shape." + field, "1e400"});
        refused(shape("\"1\""), {"geometries.g.shape." + field, "must be a number"});
    }
    for (const auto& [kind, field] : {std::pair("box", "half"), std::pair("ellipsoid", "semi_axes")})
        for (const char* value : {"0", "-1", "1e16", "1e-320"})
            refused(fmt::format(R"({{"shape":{{"kind":"{}","{}":[1,{},1]}}}})", kind, field, value),
                    {"geometries.g.shape", "y is"});
    refused(R"({"shape":{"kind":"capsule","radius":1,"length":-1}})", {"length is -1", "0 or above"});
    taken(R"({"shape":{"kind":"capsule","radius":1,"length":0}})");
    refused(R"({"shape":{"kind":"half_space","radius":1}})", {"radius: unknown key"});
}

TEST_F(HostileEnvironments, HullsWithoutAVolumeAreRefused)
{
    const auto hull = [](const std::string& points) {
        return fmt::format(R"({{"shape":{{"kind":"convex_hull","points":[{}]}}}})", points);
    };
    refused(hull(""), {"0 points", "at least 4"});
    refused(hull("[0,0,0],[1,0,0],[0,1,0]"), {"3 points", "at least 4"});
    refused(hull("[0,0,0],[1,1,1],[2,2,2],[3,3,3],[4,4,4]"), {"5 points", "in a plane", "needs four that do not"});
    refused(hull("[1,2,3],[1,2,3],[1,2,3],[1,2,3],[1,2,3]"), {"5 points", "in a plane"});
    refused(hull("[0,0,0],[1,0,0],[0,1,0],[1,1,0],[0.5,0.5,0]"), {"5 points", "in a plane"});
    refused(hull("[0,0,0],[1,0,0],[0,1,0],[1,1,1e-18]"), {"4 points", "in a plane"});
    refused(hull("[0,0,0],[1e-320,0,0],[0,1e-320,0],[0,0,1e-320]"), {"4 points", "in a plane"});
    refused(hull("[0,0,0],[1e16,0,0],[0,1,0],[0,0,1]"), {"point 1", "beyond"});
    refused(hull("[0,0,0],[1e999,0,0],[0,1,0],[0,0,1]"), {"points[1][0]", "1e999"});
    taken(hull("[0,0,0],[1,0,0],[0,1,0],[0,0,1],[0,0,1],[1,0,0]"));
}

} // namespace
} // namespace oncollide::test
