// Files as assemblies: parts by node, at their poses, with names, sharing meshes.
#include <numbers>

#include <gtest/gtest.h>

#include "allocations.hpp"
#include "scenes/files/mesh_writers.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

class AssemblyFile : public ::testing::Test {
protected:
    /// One mesh, a box of 2 x 4 x 6, placed by these nodes; nodes[0] is the root.
    Assembly load(const std::string& nodes, double scale = 1, int threads = 1)
    {
        return load_assembly(folder_.write("a.glb", test::as_glb(box_, nodes)), {.scale = scale, .threads = threads});
    }
    static const Mesh& mesh_of(const Assembly& assembly, std::size_t part)
    {
        return std::get<Mesh>(assembly.meshes[assembly.parts[part].mesh]->data);
    }
    /// All corners of all parts in the world, sorted.
    static std::vector<std::array<double, 3>> corners(const Assembly& assembly)
    {
        std::vector<std::array<double, 3>> found;
        for (std::size_t i = 0; i < assembly.parts.size(); ++i)
            for (const Vector3d& v : mesh_of(assembly, i).vertices) {
                const Vector3d p = assembly.parts[i].pose * v;
                found.push_back({p.x(), p.y(), p.z()});
            }
        std::ranges::sort(found);
        return found;
    }

    Mesh box_ = make_box_mesh({1, 2, 3});
    test::TemporaryFolder folder_;
};

TEST_F(AssemblyFile, EachNodeWithAMeshIsAPartAndSharesTheMesh)
{
    const Assembly found = load(R"({"name":"plant","children":[1,2,3]},)"
                                R"({"name":"left","mesh":0,"translation":[10,0,0]},)"
                                R"({"name":"turned","mesh":0,"rotation":[0,0,0.6,0.8],"translation":[0,20,0]},)"
                                R"({"name":"empty"})");
    ASSERT_EQ(found.parts.size(), 2u);
    EXPECT_EQ(found.meshes.size(), 1u);
    EXPECT_EQ(found.parts[0].name, "left");
    EXPECT_EQ(found.parts[1].path, "plant/turned");
    EXPECT_EQ(found.parts[0].above, 0u);
    EXPECT_EQ(found.parts[0].pose.translation(), Vector3d(10, 0, 0));
    EXPECT_TRUE(found.parts[0].pose.linear().isIdentity(0)) << "a pose without rotation is not rounded";
    EXPECT_NEAR(found.parts[1].pose.linear()(1, 0), 0.96, 1e-15);
}

TEST_F(AssemblyFile, PartsHaveTheExtrasOfTheirNodes)
{
    const std::string extras = R"({"class": "IfcWall", "deflection": 1e-4})", long_text(4000, 'x');
    on_file_warning([](const std::string& line) {
        EXPECT_NE(line.find("extras"), line.npos) << line;
        EXPECT_NE(line.find("1 part "), line.npos) << line;
    });
    const Assembly found =
        load(R"({"children":[1,2,3,4],"extras":{"of": "a group"}},{"mesh":0,"extras":)" + extras +
             R"(},{"mesh":0},{"mesh":0,"extras":[1, "two"]},{"mesh":0,"extras":")" + long_text + R"("})");
    on_file_warning(nullptr);
    ASSERT_EQ(found.parts.size(), 4u);
    EXPECT_EQ(found.parts[0].extras, extras);
    EXPECT_EQ(found.parts[1].extras, "");
    EXPECT_EQ(found.parts[2].extras, R"([1, "two"])");
    EXPECT_EQ(found.parts[3].extras, "") << "instances could copy it a hundred thousand times";
}

TEST_F(AssemblyFile, FilesOfOtherFormatsAreReadAsTheGlbFileThatAConverterMakes)
{
    const auto convert = [this](const std::filesystem::path& file) -> std::string {
        if (file.stem() == "bad") throw Error(ErrorKind::bad_data, file.string() + ": nothing in it");
        if (file.stem() == "cut") return "glTF";
        return test::as_glb(box_, R"({"children":[1,2]},{"mesh":0,"name":"one"},{"mesh":0,"translation":[9,0,0]})");
    };
    const std::filesystem::path part = folder_.write("part.Cad", "anything"), cut = folder_.write("cut.cad", "x"),
                                bad = folder_.write("bad.cad", "x");
    EXPECT_FALSE(is_assembly_file(part));
    convert_files({"cad", "drawing"}, convert);
    EXPECT_TRUE(is_assembly_file(part));
    EXPECT_EQ(mesh_extensions().back(), "drawing");
    const Assembly found = load_assembly(part);
    ASSERT_EQ(found.parts.size(), 2u);
    EXPECT_EQ(found.parts[0].name, "one");
    EXPECT_EQ(load_mesh(part).triangles.size(), 24u);
    expect_error(
        ErrorKind::bad_data, [&] { load_assembly(bad); }, "bad.cad: nothing in it");
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(cut); }, "cut.cad: ");
    expect_error(
        ErrorKind::no_input, [&] { load_mesh(folder_ / "none.cad"); }, "none.cad: no such file");
    convert_files({}, nullptr);
    EXPECT_EQ(mesh_extensions().back(), "3mf");
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(part); }, "part.Cad", "unknown kind of mesh file");
}

TEST_F(AssemblyFile, ScaledPartsShareAScaledMesh)
{
    // Like files of many programs that write millimetres: a scale above all nodes.
    const Assembly found = load(R"({"scale":[0.001,0.001,0.001],"children":[1,2,3]},)"
                                R"({"mesh":0},{"mesh":0,"rotation":[0.6,0,0,0.8],"translation":[500,0,0]},)"
                                R"({"mesh":0,"scale":[1,1,2]})");
    ASSERT_EQ(found.parts.size(), 3u);
    EXPECT_EQ(found.meshes.size(), 2u);
    EXPECT_EQ(found.parts[0].mesh, found.parts[1].mesh);
    EXPECT_NE(found.parts[0].mesh, found.parts[2].mesh);
    EXPECT_NEAR(mesh_of(found, 0).bounds.max.z(), 0.003, 1e-17);
    EXPECT_NEAR(mesh_of(found, 2).bounds.max.z(), 0.006, 1e-17);
    EXPECT_NEAR(found.parts[1].pose.translation().x(), 0.5, 1e-15);
    EXPECT_EQ(found.parts[0].name, "node 1");
}

TEST_F(AssemblyFile, EveryPartLiesWhereTheMergedMeshHasIt)
{
    const std::string nodes = R"({"scale":[1,2,0.5],"rotation":[0,0.6,0,0.8],"children":[1,2,3]},)"
                              R"({"mesh":0,"rotation":[0.36,0.48,0,0.8]},{"mesh":0,"scale":[-1,1,1]},)"
                              R"({"matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,7,8,9,1],"children":[4]},{"mesh":0})";
    const Assembly parts = load(nodes, 10, 2);
    const Mesh merged = load_mesh(folder_.path() / "a.glb", {.scale = 10});
    std::vector<std::array<double, 3>> expected;
    for (const Vector3d& v : merged.vertices) expected.push_back({v.x(), v.y(), v.z()});
    std::ranges::sort(expected);
    const auto found = corners(parts);
    ASSERT_EQ(found.size(), expected.size());
    // Rounding may change the order of sorting, so searches for a near corner.
    for (const auto& p : found)
        EXPECT_TRUE(std::ranges::any_of(
            expected, [&](const auto& q) { return (Vector3d(p.data()) - Vector3d(q.data())).norm() < 1e-12; }));
    for (std::size_t i = 0; i < parts.parts.size(); ++i) EXPECT_TRUE(is_closed(mesh_of(parts, i)));
}

TEST_F(AssemblyFile, AMirroredPartKeepsItsOutsideOut)
{
    const auto volume = [](const Mesh& mesh) {
        double sum = 0;
        for (const Triangle& t : mesh.triangles)
            sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
        return sum;
    };
    EXPECT_GT(volume(mesh_of(load(R"({"mesh":0,"scale":[-1,1,1]})"), 0)), 47);
}

TEST_F(AssemblyFile, OtherFilesAreOnePart)
{
    const Assembly found = load_assembly(folder_.write("bracket.stl", test::as_binary_stl(box_)), {.scale = 0.001});
    ASSERT_EQ(found.parts.size(), 1u);
    EXPECT_EQ(found.parts[0].name, "bracket");
    EXPECT_EQ(found.parts[0].above, no_node_above);
    EXPECT_NEAR(mesh_of(found, 0).bounds.max.z(), 0.003, 1e-17);
}

TEST_F(AssemblyFile, AnAssemblyWithoutPartsIsRefused)
{
    const auto path = folder_.write("a.glb", test::as_glb(box_, R"({"name":"nothing"})"));
    expect_error(
        ErrorKind::bad_data, [&] { load_assembly(path); }, "a.glb", "holds no triangle");
    expect_error(
        ErrorKind::usage, [&] { load_assembly(path, {.scale = 0}); }, "the scale is 0");
    expect_error(
        ErrorKind::bad_data, [&] { load(R"({"mesh":0,"translation":[1e16,0,0]})"); }, "nodes[0]", "beyond 1e15");
    expect_error(
        ErrorKind::bad_data, [&] { load(R"({"mesh":7})"); }, "a.glb");
}

TEST_F(AssemblyFile, LongChainsOfNodesMakeNoLongNames)
{
    std::string nodes = R"({"name":"n","mesh":0,"children":[1]})";
    for (int i = 1; i < 3000; ++i) nodes += fmt::format(R"(,{{"name":"n","mesh":0,"children":[{}]}})", i + 1);
    const Assembly found = load(nodes + R"(,{"mesh":0})");
    ASSERT_EQ(found.parts.size(), 3001u);
    std::string ancestors;
    for (int i = 0; i < 63; ++i) ancestors += "n/";
    EXPECT_EQ(found.parts.back().path, ancestors + "node 3000");
}

TEST_F(AssemblyFile, AnObjFileIsDividedIntoItsObjectsIfRequested)
{
    // A triangle before the first object, an L of one polygon, and a square; groups do not count beside objects.
    const auto path = folder_.write("l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3\n"
                                             "o the L\ng a\nf 1 2 3 4 5 6\ng b\no square\nv 5 5 5\nv 6 5 5\nv 6 6 5\n"
                                             "v 5 6 5\nf -4 -3 -2 -1\n");
    EXPECT_EQ(load_assembly(path).parts.size(), 1u);
    const Assembly found = load_assembly(path, {.scale = 2, .objects = true});
    ASSERT_EQ(found.parts.size(), 3u);
    const auto expect_part = [&](std::size_t number, const char* name, std::size_t triangles, std::size_t vertices) {
        EXPECT_EQ(found.parts[number].name, name);
        EXPECT_EQ(found.parts[number].above, no_node_above);
        EXPECT_EQ(mesh_of(found, number).triangles.size(), triangles) << name;
        EXPECT_EQ(mesh_of(found, number).vertices.size(), vertices) << name;
    };
    expect_part(0, "l", 1, 3), expect_part(1, "the L", 4, 6), expect_part(2, "square", 2, 4);
    EXPECT_EQ(mesh_of(found, 2).bounds.max, Eigen::Vector3d(12, 12, 10));
}

TEST_F(AssemblyFile, PathsOfNestedNodesStayShort)
{
    std::string nodes;
    constexpr int links = 2000;
    for (int i = 0; i < links; ++i)
        nodes += fmt::format(R"({{"name":"{}{}","mesh":0,"children":[{}]}},)", std::string(1000, 'n'), i, i + 1);
    nodes += R"({"name":"last","mesh":0})";
    const auto path = folder_.write("a.glb", test::as_glb(box_, nodes));
    const std::size_t before = allocated_bytes;
    const Assembly found = load_assembly(path);
    EXPECT_LT(allocated_bytes - before, 50'000'000u) << "names were joined at each depth";
    ASSERT_EQ(found.parts.size(), 2001u);
    EXPECT_EQ(found.parts.back().name, "last");
    EXPECT_EQ(found.parts.back().path.size(), 4 + 4 * 200u) << found.parts.back().path;
    EXPECT_TRUE(found.parts.back().path.ends_with("nnn1999/last"));
    for (const AssemblyPart& part : found.parts) {
        ASSERT_LE(part.name.size(), 200u);
        ASSERT_LE(part.path.size(), 1000u);
    }
    EXPECT_NE(found.parts[17].name.find("nnn...nnn"), std::string::npos);
    EXPECT_TRUE(found.parts[17].name.ends_with("nnn17")) << "names that differ at their ends stay different";
}

} // namespace
} // namespace oncollide
