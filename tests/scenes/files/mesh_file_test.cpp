#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/reading_progress.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/mesh/decimal.hpp>

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scenes/files/mesh_samples.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::mesh_file_test {
namespace {

/// Through memory: GCC 12's -ftree-slp-vectorize optimises double -> float -> double away and drops the rounding.
Vector3d rounded_to_float(const Vector3d& p)
{
    volatile float x = static_cast<float>(p.x()), y = static_cast<float>(p.y()), z = static_cast<float>(p.z());
    return {x, y, z};
}

TEST(MeshFile, EveryFormatGivesTheMeshBack)
{
    const test::TemporaryFolder folder;
    const Mesh mesh = make_torus_mesh(2, 0.7, 100);
    for (const Sample& sample : samples(mesh)) {
        SCOPED_TRACE(sample.name);
        const Mesh read = load_mesh(folder.write(sample.name, sample.bytes));
        ASSERT_EQ(read.triangles.size(), mesh.triangles.size());
        EXPECT_EQ(read.vertices.size(), mesh.vertices.size()) << "equal positions become one vertex";
        EXPECT_TRUE(is_closed(read));
        if (sample.shared) {
            EXPECT_EQ(read.vertices, mesh.vertices);
            EXPECT_EQ(read.triangles, mesh.triangles);
        }
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                Vector3d expected = mesh.vertices[mesh.triangles[t][k]];
                if (!sample.exact) expected = rounded_to_float(expected);
                ASSERT_EQ(read.vertices[read.triangles[t][k]], expected);
            }
    }
}

TEST(MeshFile, ObjAndOffKeepEveryBitOfADouble)
{
    const test::TemporaryFolder folder;
    Mesh mesh = make_soup_mesh(200, 0.1, 1e6, 1);
    mesh.vertices[0] = {5e-324, -0.0, 0.1 + 0.2};
    EXPECT_EQ(load_mesh(folder.write("a.obj", test::as_obj(mesh))).vertices, mesh.vertices);
    EXPECT_EQ(load_mesh(folder.write("a.off", test::as_off(mesh))).vertices, mesh.vertices);
    EXPECT_TRUE(std::signbit(load_mesh(folder.path() / "a.obj").vertices[0].y()));
}

TEST(MeshFile, TrianglesWithoutAreaStay)
{
    const test::TemporaryFolder folder;
    const Mesh mesh =
        make_mesh("m", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 0, 0}, {0, 1, 3}, {3, 1, 3}});
    for (const Sample& sample : samples(mesh)) {
        SCOPED_TRACE(sample.name);
        const Mesh read = load_mesh(folder.write(sample.name, sample.bytes));
        EXPECT_EQ(read.triangles.size(), 4u);
        EXPECT_EQ(read.zero_area, 3u);
    }
}

TEST(MeshFile, ObjDialectsAreUnderstood)
{
    const test::TemporaryFolder folder;
    const Mesh mesh =
        load_mesh(folder.write("a.obj", "\n# comment\r\nmtllib x.mtl\r\no thing\ng a b\ns off\nusemtl red\n"
                                        "v 0 0 0 1.0\nv +1 0 0 0.5 0.5 0.5\nv 1 1e0 0\t\nv 0 1 .0 # corner\n"
                                        "vt 0 0\nvn 0 0 1\nl 1 2\np 1\n"
                                        "f 1/1 2/1 3/1\nf 1//1 3//1 4//1\nf -4 -3 -2\nf 1/1/1 \\\n 2/1/1 4/1/1\n"));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 3}}));
    EXPECT_EQ(mesh.vertices[1], Vector3d(1, 0, 0));
    // No end of line; faces before their vertices.
    EXPECT_EQ(load_mesh(folder.write("b.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0")).triangles.size(), 1u);
}

TEST(MeshFile, PlainLinesOfObjMeanWhatAnyLineMeans)
{
    const test::TemporaryFolder folder;
    // A comment in the line of a face, or of a continued vertex, passes the line to the general reader.
    const std::string heads[] = {"", "# text\r\n\n", "o x\n", "v 9 9 9\n"};
    const std::string numbers[] = {"0",
                                   "-0.0",
                                   "+1.5",
                                   ".5",
                                   "5.",
                                   "1e-3",
                                   "123456789012.34567890123456789",
                                   "0.1",
                                   "1E5",
                                   "90071992547409.93",
                                   "90071992547409.92",
                                   "0.30000000000000004",
                                   "4.9e-324",
                                   "00000000000000000000000000001.25",
                                   "12345678.87654321",
                                   "-0.000001"};
    for (const std::string& head : heads)
        for (const std::string& x : numbers)
            for (const char* end : {"\n", "\r\n", " \t\n", " 0.5 0.5 0.5\n"}) {
                SCOPED_TRACE(head + x + end);
                const std::string text = head + "v " + x + "  0\t" + x + end + "v 1 0 0" + end + "v 0 1 0" + end;
                const std::string face = head == "v 9 9 9\n" ? "f 2 3/7 4//8" : "f 1 2/7 3//8";
                const Mesh plain = load_mesh(folder.write("a.obj", text + face + " \nf -3 -2/1/1 -1\n"));
                std::string any = text + face + " # corners\nf -3 -2/1/1 \\\n-1\n"; // each line ends with a comment
                for (std::size_t at = any.find("v "); at != any.npos; at = any.find("v ", at + 8))
                    any.replace(at, 2, "v \\\n");
                const Mesh other = load_mesh(folder.write("b.obj", any));
                EXPECT_EQ(plain.triangles, other.triangles);
                ASSERT_EQ(plain.vertices.size(), other.vertices.size());
                for (std::size_t i = 0; i < plain.vertices.size(); ++i)
                    for (int axis = 0; axis < 3; ++axis) {
                        EXPECT_EQ(plain.vertices[i][axis], other.vertices[i][axis]);
                        EXPECT_EQ(std::signbit(plain.vertices[i][axis]), std::signbit(other.vertices[i][axis]));
                    }
                EXPECT_EQ(plain.vertices[head == "v 9 9 9\n"].x(), std::strtod(x.c_str(), nullptr));
            }
}

TEST(MeshFile, DecimalsAreRoundedAsFromCharsRoundsThem)
{
    std::size_t read = 0;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
        const auto digits = [&](std::uint64_t k) { return splitmix(9 * i + k) >> (splitmix(i + 77 * k) % 64); };
        std::string text = fmt::format("{}{}", i % 3 ? "" : "-", digits(1));
        if (i % 5) text += fmt::format(".{}{}", std::string(i % 7, '0'), digits(2));
        double expected = 0, value = 0;
        ASSERT_EQ(std::from_chars(text.data(), text.data() + text.size(), expected).ec, std::errc{});
        const std::string line = text + (i % 2 ? "\n" : " 1234567890");
        if (const char* end = read_decimal(line.data(), line.data() + line.size(), value)) {
            ++read;
            ASSERT_EQ(end, line.data() + text.size()) << text;
            ASSERT_EQ(value, expected) << text;
        }
    }
    EXPECT_GT(read, 50'000u) << "most are plain";
}

TEST(MeshFile, PolygonsAmongTrianglesKeepTheirOrderAndTheirLines)
{
    const test::TemporaryFolder folder;
    const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    const Mesh mesh =
        load_mesh(folder.write("a.obj", square + "f 1 2 3\nf 1 2 3 4\n# text\n\nf 2 3 4\nf 4 3 2 1\nf 3 4 1\n"));
    EXPECT_EQ(mesh.triangles,
              (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {1, 2, 3}, {3, 2, 1}, {3, 1, 0}, {2, 3, 0}}));
    expect_bad("a.obj", square + "f 1 2 3\n\nf 1 2 3 4\n\n# text\nf 2 3 9\n", "line 10: face uses vertex 9");
    expect_bad("a.obj", square + "f 1 2 3\n\nf 1 2 3 9\nf 2 3 8\n", "line 7: face uses vertex 9");
    expect_bad("a.obj", square + "f 1 2 3\nf 1 2 3 4\nf 1 2 5000000000\n", "line 7: face uses vertex 5000000000");
    expect_bad("a.obj", square + "f 1 2 3\nf 1 2 8\nf 1 2 3 9\n", "line 6: face uses vertex 8");
}

TEST(MeshFile, BinaryPlyRowsOfEveryKindAreRead)
{
    const test::TemporaryFolder folder;
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty uchar red\nproperty double z\n"
        "property double x\nproperty double y\nelement face 4\nproperty short flags\n"
        "property list uchar int vertex_indices\nproperty float area\nend_header\n";
    for (const auto& [x, y, z] : {std::array{0.0, 0.0, 0.1}, {1.0, 0.0, 0.2}, {1.0, 1.0, 0.3}, {0.0, 1.0, 0.4}})
        bytes += '\7', test::append(bytes, z), test::append(bytes, x), test::append(bytes, y);
    const std::string vertices = bytes;
    const auto face = [](std::initializer_list<std::int32_t> corners) {
        std::string row;
        test::append(row, std::int16_t(5)), row += static_cast<char>(corners.size());
        for (const std::int32_t corner : corners) test::append(row, corner);
        test::append(row, 0.5f);
        return row;
    };
    const auto faces = [&](std::initializer_list<std::int32_t> third) {
        return vertices + face({0, 1, 2}) + face({0, 1, 2, 3}) + face(third) + face({1, 2, 3});
    };
    const Mesh mesh = load_mesh(folder.write("a.ply", faces({2, 3})));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {1, 2, 3}}));
    EXPECT_EQ(mesh.vertices[2], Vector3d(1, 1, 0.3));
    expect_bad("a.ply", faces({0, 1, -1}), "face uses vertex -1");
    expect_bad("a.ply", faces({0, 1, 4}), "face uses vertex 4");
    expect_bad("a.ply", faces({0, 1, 2}).substr(0, vertices.size() + 70), "ends within face 3 of 4");
    std::string infinite = faces({0, 1, 2});
    infinite.replace(vertices.size() - 4, 4, std::string("\0\0\xf0\x7f", 4));
    expect_bad("a.ply", infinite, "coordinate of vertex 3 is not finite");
}

TEST(MeshFile, OffAndPlyDialectsAreUnderstood)
{
    const test::TemporaryFolder folder;
    const Mesh off =
        load_mesh(folder.write("a.off", "COFF # colours\n# comment\n\n4 3 5\n0 0 0 255 0 0 255\n1 0 0\n1 1 0\n0 1 0\n"
                                        "4 0 1 2 3 200 100 50\n2 0 1\n3 0 1 2\n"));
    EXPECT_EQ(off.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}}));
    EXPECT_EQ(load_mesh(folder.write("b.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2")).triangles.size(), 1u);
    const Mesh ply = load_mesh(folder.write(
        "a.ply",
        "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement vertex 4\r\nproperty float nx\r\nproperty float x\r\n"
        "property list uchar float extra\r\nproperty float y\r\nproperty float z\r\nelement edge 1\r\n"
        "property int a\r\nelement face 2\r\nproperty uchar flags\r\nproperty list uchar uint vertex_index\r\n"
        "end_header\r\n9 0 2 7 7 0 0\r\n9 1 0 0 0\r\n9 1 0 1 0\r\n9 0 0 1 0\r\n5\r\n1 4 0 1 2 3\r\n1 2 0 1\r\n\r\n"));
    EXPECT_EQ(ply.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(ply.vertices[2], Vector3d(1, 1, 0));
}

TEST(MeshFile, PolygonsAreCutIntoTrianglesThatCoverThem)
{
    const test::TemporaryFolder folder;
    struct Case {
        const char* name;
        std::vector<Eigen::Vector2d> outline;
    };
    std::vector<Case> cases = {{"dart", {{0, 0}, {2, 1}, {0, 2}, {1, 1}}}, // the first diagonal would be outside
                               {"dart from its dent", {{1, 1}, {0, 0}, {2, 1}, {0, 2}}},
                               {"u", {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}},
                               {"straight corners", {{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {0, 2}}},
                               {"star", {}},
                               {"spiral", {}}};
    for (int i = 0; i < 40; ++i) {
        const double angle = i * std::numbers::pi / 20, radius = i % 2 ? 1 : 3;
        cases[4].outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    for (int i = 0; i <= 60; ++i)
        cases[5].outline.push_back((1 + i * 0.1) * Eigen::Vector2d(std::cos(i * 0.3), std::sin(i * 0.3)));
    for (int i = 60; i >= 0; --i)
        cases[5].outline.push_back((0.5 + i * 0.1) * Eigen::Vector2d(std::cos(i * 0.3), std::sin(i * 0.3)));
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name);
        std::string text, face = "f";
        double twice_area = 0;
        for (std::size_t i = 0; i < c.outline.size(); ++i) {
            const Eigen::Vector2d &p = c.outline[i], &q = c.outline[(i + 1) % c.outline.size()];
            twice_area += p.x() * q.y() - p.y() * q.x();
            text += fmt::format("v {} {} {}\n", p.y(), p.x(), 0.5 * p.x()); // tilted and mirrored
            face += fmt::format(" {}", i + 1);
        }
        const Mesh mesh = load_mesh(folder.write("a.obj", text + face + "\n"));
        ASSERT_EQ(mesh.triangles.size(), c.outline.size() - 2);
        double sum = 0; // sum of areas projected along z: equals the outline's area if nothing overlaps
        for (const Triangle& t : mesh.triangles) {
            const Vector3d& a = mesh.vertices[t[0]];
            sum += std::abs((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).z());
        }
        EXPECT_NEAR(sum, std::abs(twice_area), 1e-9);
    }
}

TEST(MeshFile, ScaleFitAndCentreApplyInThatOrder)
{
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.obj", test::as_obj(transformed("m", make_box_mesh({1, 2, 2}), 1, {-10, 0, 0})));
    EXPECT_EQ(load_mesh(path, {.scale = 2}).bounds.min, Vector3d(18, -4, -4));
    EXPECT_EQ(load_mesh(path, {.centre = true}).bounds.min, Vector3d(-1, -2, -2));
    EXPECT_EQ(load_mesh(path, {.scale = 0.5, .centre = true}).bounds.max, Vector3d(0.5, 1, 1));
    for (const double scale : {1.0, 5.0}) {
        const Mesh fitted = load_mesh(path, {.scale = scale, .fit_diagonal = 3});
        EXPECT_NEAR(fitted.bounds.diagonal(), 3, 1e-14);
        EXPECT_NEAR(fitted.bounds.centre().x(), 5, 1e-14) << "scaled about the origin";
    }
    expect_error(
        ErrorKind::usage, [&] { load_mesh(path, {.scale = 0}); }, "scale is 0");
    expect_error(
        ErrorKind::usage, [&] { load_mesh(path, {.scale = std::nan("")}); }, "scale is nan");
    expect_error(
        ErrorKind::usage, [&] { load_mesh(path, {.fit_diagonal = -1}); }, "-1");
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(path, {.scale = 1e300}); }, path.string());
    const auto spot = folder.write("spot.obj", "v 1 1 1\nf 1 1 1\n");
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(spot, {.fit_diagonal = 1}); }, "one point");
}

TEST(MeshFile, GltfNodesPlaceTheirMeshes)
{
    const test::TemporaryFolder folder;
    const Mesh box = make_box_mesh({1, 2, 3});
    const std::string nodes = R"({"children":[1,2],"translation":[100,0,0]},{"mesh":0,"translation":[10,0,0]},)"
                              R"({"mesh":0,"scale":[-1,1,1]})";
    folder.write("b.bin", test::gltf_buffer(box));
    for (const auto& path : {folder.write("a.glb", test::as_glb(box, nodes)),
                             folder.write("a.gltf", test::gltf_json(box, R"("uri":"b.bin",)", nodes))}) {
        const Mesh mesh = load_mesh(path);
        EXPECT_EQ(mesh.triangles.size(), 24u);
        EXPECT_EQ(mesh.bounds.min, Vector3d(99, -2, -3));
        EXPECT_EQ(mesh.bounds.max, Vector3d(111, 2, 3));
        double volume = 0;
        for (const Triangle& t : mesh.triangles)
            volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
        EXPECT_NEAR(volume, 96, 1e-6) << "the mirrored box still faces outward";
    }
}

TEST(MeshFile, WhoWatchesIsToldHowMuchOfALongFileIsRead)
{
    static std::vector<std::array<std::uint64_t, 2>> told;
    static std::string file;
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    while (text.size() < (std::size_t{3} << 20)) text += "vn 0 0 1 # a long line, of which nothing is kept\n";
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.obj", text);
    on_reading([](const std::string& name, std::uint64_t bytes, std::uint64_t total) {
        file = name, told.push_back({bytes, total});
    });
    load_mesh(path);
    load_mesh(folder.write("short.obj", text.substr(0, 100'000)));
    const auto of_obj = std::exchange(told, {});
    const std::string obj = file, stl = corners_on_grid(60'000, 20);
    load_mesh(folder.write("a.stl", stl));
    on_reading(nullptr);
    EXPECT_EQ(told.size(), 3u) << "after one and two megabytes, and at the end";
    EXPECT_EQ(told.back(), (std::array<std::uint64_t, 2>{stl.size(), stl.size()}));
    told = of_obj, file = obj;
    load_mesh(path);
    EXPECT_EQ(file, path.string());
    const std::uint64_t size = text.size();
    ASSERT_EQ(told.size(), 4u) << "all of it read, and taken apart after one and two megabytes, and at the end";
    EXPECT_EQ(told[0], (std::array{size, size}));
    EXPECT_NEAR(double(told[1][0]), 1 << 20, 100);
    EXPECT_NEAR(double(told[2][0]), 2 << 20, 200);
    EXPECT_EQ(told[3], (std::array{size, size}));
}

TEST(MeshFile, ReadsTheDataFolder)
{
    const auto data = test::data_folder();
    if (data.empty()) GTEST_SKIP() << "skipped: no data";
    struct Expected {
        const char* name;
        std::size_t vertices, triangles;
    };
    for (const Expected& e : {Expected{"meshes/bunny_69k.obj", 34834, 69451},
                              {"meshes/paper/bunny.obj", 1806, 1500},
                              {"poses/cow_5144.obj", 2573, 5144},
                              {"poses/bunny_5110.obj", 2616, 5110}}) {
        const Mesh mesh = load_mesh(data / e.name);
        EXPECT_EQ(mesh.vertices.size(), e.vertices) << e.name;
        EXPECT_EQ(mesh.triangles.size(), e.triangles) << e.name;
    }
    // More digits than a float has.
    EXPECT_EQ(load_mesh(data / "poses/bunny_5110.obj").vertices[0], Vector3d(-0.558309197, -0.0087593589, 0.118954651));
}

} // namespace
} // namespace oncollide::mesh_file_test
