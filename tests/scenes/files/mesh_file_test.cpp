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

#include "mesh_writers.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

struct Sample {
    std::string name, bytes;
    bool exact;  ///< keeps doubles
    bool shared; ///< keeps the order of vertices
};

/// `mesh` in every format; `name` is the file's.
std::vector<Sample> samples(const Mesh& mesh)
{
    return {{"a.obj", test::as_obj(mesh), true, true},
            {"a.off", test::as_off(mesh), true, true},
            {"text.ply", test::as_text_ply(mesh), true, true},
            {"little.ply", test::as_binary_ply(mesh, false), true, true},
            {"big.PLY", test::as_binary_ply(mesh, true), true, true},
            {"text.stl", test::as_text_stl(mesh), true, false},
            {"binary.stl", test::as_binary_stl(mesh), false, false},
            {"a.glb", test::as_glb(mesh), false, false}};
}

/// Through memory: GCC 12's -ftree-slp-vectorize optimises double -> float -> double away and drops the rounding.
Vector3d rounded_to_float(const Vector3d& p)
{
    volatile float x = static_cast<float>(p.x()), y = static_cast<float>(p.y()), z = static_cast<float>(p.z());
    return {x, y, z};
}

void expect_bad(const std::string& name, const std::string& bytes, std::string_view part)
{
    SCOPED_TRACE(bytes.substr(0, 60));
    const test::TemporaryFolder folder;
    const auto path = folder.write(name, bytes);
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(path); }, path.string() + ": ", part);
}

std::string replaced(std::string text, const std::string& from, const std::string& to)
{
    const std::size_t at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    return at == text.npos ? text : text.replace(at, from.size(), to);
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

TEST(MeshFile, StlOfManyPointsIsWelded)
{
    const test::TemporaryFolder folder;
    const Mesh mesh = make_torus_mesh(2, 0.7, 60'000); // more points than fit into the cache of recent points
    const Mesh read = load_mesh(folder.write("a.stl", test::as_binary_stl(mesh)));
    EXPECT_EQ(read.vertices.size(), mesh.vertices.size());
    EXPECT_TRUE(is_closed(read));
    // NaN points equal no point; a table of them would be searched from end to end each time.
    std::string bytes = test::as_binary_stl(make_soup_mesh(200'000, 0.1, 10, 1));
    for (std::size_t at = 84 + 12 + 50; at + 12 < bytes.size(); at += 50)
        bytes.replace(at, 4, std::string("\0\0\xc0\x7f", 4));
    expect_bad("a.stl", bytes, "a corner of facet 1 is not finite");
}

/// A binary STL with corners on a grid of `points` points along each axis, with zeros of both signs.
std::string corners_on_grid(std::uint32_t facets, std::uint64_t points)
{
    std::string bytes(80, ' ');
    test::append(bytes, facets);
    for (std::uint32_t f = 0; f < facets; ++f) {
        bytes.append(12, '\0');
        for (std::uint32_t k = 0; k < 9; ++k) {
            const float x = float(splitmix(9 * std::uint64_t{f} + k) % points) * 0.1f;
            test::append(bytes, x == 0 && f % 2 ? -x : x);
        }
        bytes.append(2, '\0');
    }
    return bytes;
}

TEST(MeshFile, StlIsWeldedAsOneCornerAfterTheOtherWouldBe)
{
    const test::TemporaryFolder folder;
    struct Case {
        std::uint32_t facets;
        std::uint64_t points;
    };
    // Few points, many points, nearly all different; numbers of facets around the sizes of batches.
    for (const auto& [facets, points] :
         {Case{1, 2}, {63, 5}, {64, 5}, {65, 5}, {4097, 30}, {120'000, 40}, {30'000, 5'000}}) {
        SCOPED_TRACE(fmt::format("{} facets, {} points along each axis", facets, points));
        const std::string bytes = corners_on_grid(facets, points);
        const Mesh read = load_mesh(folder.write("a.stl", bytes));
        std::map<std::array<float, 3>, std::uint32_t> numbers;
        ASSERT_EQ(read.triangles.size(), facets);
        for (std::size_t f = 0; f < facets; ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                std::array<float, 3> corner;
                std::memcpy(corner.data(), bytes.data() + 84 + 50 * f + 12 + 12 * k, sizeof corner);
                const auto [known, is_new] = numbers.try_emplace(corner, numbers.size());
                ASSERT_EQ(read.triangles[f][k], known->second) << "facet " << f;
                if (!is_new) continue;
                const Vector3d& vertex = read.vertices[known->second];
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_EQ(vertex[axis], corner[axis]);
                    ASSERT_EQ(std::signbit(vertex[axis]), std::signbit(corner[axis]))
                        << "the signs of the first corner";
                }
            }
        EXPECT_EQ(read.vertices.size(), numbers.size());
    }
}

TEST(MeshFile, EveryCornerOfAnStlThatIsNotFiniteIsNamed)
{
    const std::string bytes = corners_on_grid(5000, 20);
    for (const std::size_t facet : {0u, 63u, 64u, 4095u, 4096u, 4999u})
        for (const std::uint32_t bits : {0x7f800000u, 0xff800000u, 0x7fc00000u, 0x7f800001u, 0xffffffffu}) {
            std::string bad = bytes;
            for (std::size_t k = 0; k < 2; ++k) std::memcpy(bad.data() + 84 + 50 * facet + 24 + 4 * k, &bits, 4);
            std::memset(bad.data() + 84 + 50 * facet + 32, 0, 4);
            expect_bad("a.stl", bad, fmt::format("a corner of facet {} is not finite", facet));
        }
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

TEST(MeshFile, BinaryStlThatBeginsWithSolidIsNotText)
{
    const test::TemporaryFolder folder;
    std::string bytes = test::as_binary_stl(make_box_mesh({1, 1, 1}));
    bytes.replace(0, 5, "solid");
    EXPECT_EQ(load_mesh(folder.write("a.stl", bytes)).triangles.size(), 12u);
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

TEST(MeshFile, MissingFilesAndFoldersAreNoInput)
{
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.path() / "folder.obj");
    const auto no_input = [&](const std::filesystem::path& path, const char* part) {
        expect_error(
            ErrorKind::no_input, [&] { load_mesh(path); }, path.string() + ": ", part);
    };
    no_input(folder.path() / "missing.obj", "no such file");
    no_input(folder.path() / "folder.obj", "folder");
    no_input("/dev/null", "not a readable file");
    no_input("", "no such file");
}

TEST(MeshFile, UnknownKindsListTheKnown)
{
    expect_bad("a.png", "\x89PNG\r\n", "known are obj, stl, ply, off, gltf, glb, dae, 3mf");
    expect_bad("a", "v 0 0 0\n", "known are obj");
    for (const std::string& extension : mesh_extensions()) {
#ifndef ONCOLLIDE_XML
        if (extension == "dae" || extension == "3mf") continue; // refused with any contents
#endif
        expect_bad("empty." + extension, "", "empty");
        expect_bad("picture." + extension, std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16), "");
        expect_bad("zeros." + extension, std::string(1000, '\0'), "");
        expect_bad("words." + extension, "a text about nothing\nin two lines\n", "");
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

TEST(MeshFile, BadObjIsRefusedWithItsLine)
{
    const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    expect_bad("a.obj", three + "f 1 2 9000\n", "line 4: face uses vertex 9000, but the file has 3 vertices");
    expect_bad("a.obj", three + "f 1 2 0\n", "line 4: face uses vertex 0");
    expect_bad("a.obj", three + "f 1 2 -4\n", "line 4: face uses vertex -4");
    expect_bad("a.obj", three + "f 1 2\n", "line 4: face has 2 corners");
    expect_bad("a.obj", three + "f 1 2 x\n", "line 4: face corner 'x'");
    expect_bad("a.obj", three + "f 1 2 3.5\n", "line 4: face corner '3.5'");
    expect_bad("a.obj", three + "f 1 2 99999999999999999999\n", "line 4");
    expect_bad("a.obj", "v 0 0\n" + three + "f 1 2 3\n", "line 1: coordinate z is missing");
    expect_bad("a.obj", "v 0 0 nan\n" + three + "f 1 2 3\n", "line 1: coordinate z is 'nan'");
    expect_bad("a.obj", "v 0 -inf 0\n" + three + "f 1 2 3\n", "line 1: coordinate y is '-inf'");
    expect_bad("a.obj", "v 0 1e999 0\n" + three + "f 1 2 3\n", "line 1: coordinate y is '1e999'");
    expect_bad("a.obj", "v 0 1,5 0\n" + three + "f 1 2 3\n", "line 1: coordinate y is '1,5'");
    expect_bad("a.obj", "v 1e16 0 0\n" + three + "f 1 2 3\n", "vertex 0 is too far");
    expect_bad("a.obj", three, "no triangle");
    expect_bad("a.obj", three + "l 1 2\n", "no triangle");
    expect_bad("a.obj", three + "face 1 2 3\n", "line 4: unknown statement 'face'");
}

TEST(MeshFile, BadOffIsRefused)
{
    const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    expect_bad("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "ends after 2 of 3 vertices");
    expect_bad("a.off", "OFF\n3 2 0\n" + body, "ends after 1 of 2 faces");
    expect_bad("a.off", "OFF\n3 1 0\n" + body + "3 0 1 2\n", "line 7: more lines");
    expect_bad("a.off", "OFF\n4000000000 1 0\n" + body, "cannot hold");
    expect_bad("a.off", "OFF\n-3 1 0\n" + body, "cannot hold");
    expect_bad("a.off", "OFF BINARY\n3 1 0\n" + body, "binary OFF");
    expect_bad("a.off", "4OFF\n3 1 0\n" + body, "'4OFF'");
    expect_bad("a.off", "OFF\n", "ends after");
    expect_bad("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 6: face uses vertex 3, but the file has 3");
    expect_bad("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "line 6: face uses vertex -1");
    expect_bad("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "line 6: a vertex number of the face is missing");
    expect_bad("a.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "line 4: coordinate z is 'nan'");
    expect_bad("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "no triangle");
}

TEST(MeshFile, BadPlyIsRefused)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    const std::string text = test::as_text_ply(box), binary = test::as_binary_ply(box, false);
    expect_bad("a.ply", replaced(text, "vertex 8", "vertex 9"), "");
    expect_bad("a.ply", replaced(text, "vertex 8", "vertex 4000000000"), "line 4: a file of");
    expect_bad("a.ply", replaced(text, "vertex 8", "vertex -8"), "line 4");
    expect_bad("a.ply", replaced(text, "face 12", "face 13"), "ends within face 12 of 13");
    expect_bad("a.ply", replaced(text, "face 12", "face 11"), "bytes follow");
    expect_bad("a.ply", replaced(text, "property double z\n", ""), "lacks a property x, y or z");
    expect_bad("a.ply", replaced(text, "property double z", "property half z"), "line 7: unknown type 'half'");
    expect_bad("a.ply", replaced(text, "vertex_indices", "corners"), "vertex_indices");
    expect_bad("a.ply", replaced(text, "list uchar", "list float"), "whole-number");
    expect_bad("a.ply", replaced(text, "ascii", "utf8"), "line 2: unknown format 'utf8'");
    expect_bad("a.ply", replaced(text, "format ascii 1.0\n", ""), "no format");
    expect_bad("a.ply", replaced(text, "end_header", "end"), "unknown header line 'end'");
    expect_bad("a.ply", replaced(text, "3 0 4 6", "3 0 4 8"), "face uses vertex 8, but the file has 8");
    expect_bad("a.ply", replaced(text, "3 0 4 6", "3 0 4 -1"), "face uses vertex -1");
    expect_bad("a.ply", replaced(text, "3 0 4 6", "3 0 4 0.5"), "whole number");
    expect_bad("a.ply", replaced(text, "3 0 4 6", "-3 0 4 6"), "has -3 corners");
    expect_bad("a.ply", replaced(text, "-1 -1 -1 7", "-1 nan -1 7"), "vertex 0 is not finite");
    for (std::size_t size = 0; size < binary.size(); size += 5) expect_bad("a.ply", binary.substr(0, size), "");
    expect_bad("a.ply", binary + '\0', "1 bytes follow");
}

TEST(MeshFile, BadStlIsRefused)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    const std::string text = test::as_text_stl(box), binary = test::as_binary_stl(box);
    for (std::size_t size = 0; size < binary.size(); size += 7) expect_bad("a.stl", binary.substr(0, size), "");
    expect_bad("a.stl", binary + '\0', "must have 684 bytes, but the file has 685");
    for (std::size_t size = 0; size < text.find("endsolid"); size += 13) expect_bad("a.stl", text.substr(0, size), "");
    expect_bad("a.stl", "solid empty\nendsolid empty\n", "no triangle");
    expect_bad("a.stl", replaced(text, "outer loop", "inner loop"), "line 3: 'inner' stands where 'outer'");
    expect_bad("a.stl", replaced(text, "vertex -1 -1 -1", "vertex -1 -1"), "line 4: coordinate z is missing");
    expect_bad("a.stl", replaced(text, "vertex -1 -1 -1", "vertex -1 inf -1"), "line 4: coordinate y is 'inf'");
    expect_bad("a.stl", replaced(text, "endloop", "vertex 0 0 0\nendloop"), "line 7");
    std::string infinite = binary;
    infinite.replace(84 + 12, 4, std::string("\0\0\x80\x7f", 4));
    expect_bad("a.stl", infinite, "not finite");
}

TEST(MeshFile, BadGltfIsRefused)
{
    const test::TemporaryFolder folder;
    const Mesh box = make_box_mesh({1, 2, 3});
    const std::string glb = test::as_glb(box), json = test::gltf_json(box, R"("uri":"b.bin",)");
    for (std::size_t size = 0; size < glb.size(); size += 11) expect_bad("a.glb", glb.substr(0, size), "");
    std::string buffer = test::gltf_buffer(box);
    const auto bad = [&](const std::string& text, std::string_view part) {
        folder.write("b.bin", buffer);
        const auto path = folder.write("a.gltf", text);
        expect_error(
            ErrorKind::bad_data, [&] { load_mesh(path); }, path.string() + ": ", part);
    };
    bad(replaced(json, "b.bin", "missing.bin"), "missing.bin");
    bad(replaced(json, R"("count":36)", R"("count":4000000000)"), "");
    bad(replaced(json, R"("count":36)", R"("count":35)"), "35 corners");
    bad(replaced(json, R"("count":36)", R"("count":39)"), "");
    bad(replaced(json, R"("count":8)", R"("count":7)"), "triangle 2 uses vertex 7, but there are 7 vertices");
    bad(replaced(json, R"("type":"VEC3")", R"("type":"VEC3","sparse":{})"), "sparse");
    bad(replaced(json, R"("mode":4)", R"("mode":9)"), "mode 9");
    bad(replaced(replaced(json, R"("mode":4)", R"("mode":2)"), R"("indices":0)", R"("indices":1)"), "no triangle");
    bad(replaced(json, "5125", "5126"), "of indices");
    bad(replaced(json, R"("version":"2.0")", R"("version":2)"), "asset.version: is a number, must be a text");
    bad(replaced(json, R"("mode":4)", R"("mode":1)"), "no triangle");
    bad(replaced(json, R"("version":"2.0")", R"("version":"1.0")"), "version '1.0'");
    bad(replaced(json, R"({"mesh":0})", R"({"mesh":3})"), "meshes[3]");
    bad(replaced(json, R"({"mesh":0})", R"({"children":[0]})"), "own ancestors");
    bad(std::string(100000, '['), "nested deeper");
    bad("{}", "glTF");
    buffer[0] = 99;
    bad(json, "triangle 0 uses vertex 99, but there are 8 vertices");
    buffer = test::gltf_buffer(box).substr(0, 200);
    bad(json, "truncated: the file of its buffer, 'b.bin', has 200 of 240 bytes");
}

TEST(MeshFile, APolygonThatCrossesItselfEverywhereIsCutInReasonableTime)
{
    const test::TemporaryFolder folder;
    constexpr int corners = 4096;
    std::string text, face = "f";
    for (int i = 0; i < corners; ++i) {
        text += fmt::format("v {} {} 0\n", u01(4, i, 0), u01(4, i, 1));
        face += fmt::format(" {}", i + 1);
    }
    for (int i = 0; i < 20; ++i) text += face + "\n";
    const auto path = folder.write("a.obj", text);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(load_mesh(path).triangles.size(), 20u * (corners - 2));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

// A short, repeatable fuzzer: for any bytes the result is a valid mesh or an Error.
TEST(MeshFile, DamagedFilesGiveAnErrorOrAValidMesh)
{
    const test::TemporaryFolder folder;
    std::uint64_t errors = 0, index = 0;
    for (const Sample& sample : samples(make_torus_mesh(2, 0.7, 40)))
        for (int round = 0; round < 150; ++round, ++index) {
            const auto pick = [&](std::uint64_t k, std::size_t n) {
                return static_cast<std::size_t>(u01(9, index, k) * n);
            };
            std::string bytes = sample.bytes;
            if (round % 3 != 0) bytes.resize(1 + pick(0, bytes.size() - 1));
            for (std::uint64_t flip = 0; round % 3 != 1 && flip < 4; ++flip)
                bytes[pick(10 + flip, bytes.size())] = "0123456789-e. {}[]\n\xff"[pick(20 + flip, 20)];
            const auto path = folder.write(sample.name, bytes);
            try {
                const Mesh mesh = load_mesh(path);
                EXPECT_NO_THROW(make_mesh("again", mesh.vertices, mesh.triangles));
            } catch (const Error& error) {
                EXPECT_TRUE(std::string(error.what()).starts_with(path.string() + ": ")) << error.what();
                EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(ErrorKind::bad_data));
                ++errors;
            }
        }
    EXPECT_GT(errors, index / 2);
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
} // namespace oncollide
