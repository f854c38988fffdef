// glTF files that crashed a reader, or could: each must be read or refused with one line, in time and memory
// proportionate to its size.
#include <chrono>
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "hostile/structure.hpp"
#include "scenes/files/mesh_writers.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

/// The data of one triangle, (0, 0, 0), (1, 0, 0), (0, 1, 0), as base64.
constexpr const char* triangle_data =
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";

struct Parts {
    std::string nodes = R"([{"mesh":0}])", more = "", uri = triangle_data, accessors = "", views = "", primitive = "";
    std::string view = R"("buffer":0,"byteLength":36)";
    std::string accessor = R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3")";
    int bytes = 36;
};

std::string gltf(const Parts& p)
{
    return fmt::format(R"({{"asset":{{"version":"2.0"}},"nodes":{},"meshes":[{{"primitives":[{{"attributes":)"
                       R"({{"POSITION":0}}{}}}]}}],"accessors":[{{{}}}{}],"bufferViews":[{{{}}}{}],)"
                       R"("buffers":[{{"uri":"{}","byteLength":{}}}]{}}})",
                       p.nodes, p.primitive, p.accessor, p.accessors, p.view, p.views, p.uri, p.bytes, p.more);
}

class HostileGltf : public ::testing::Test {
protected:
    Mesh load(const std::string& text) { return load_mesh(folder_.write("a.gltf", text)); }
    void refuse(const std::string& text, std::string_view part)
    {
        SCOPED_TRACE(text.substr(0, 500));
        const auto path = folder_.write("a.gltf", text);
        expect_error(
            ErrorKind::bad_data, [&] { load_mesh(path); }, path.string(), part);
    }
    test::TemporaryFolder folder_;
};

TEST_F(HostileGltf, TheTriangleOfTheseTestsIsRead)
{
    EXPECT_EQ(load(gltf({})).vertices, (std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(load("\xef\xbb\xbf" + gltf({})).triangles.size(), 1u);
}

TEST_F(HostileGltf, SkinsWithoutInverseBindMatricesAndMimeTypesWithoutASlashCrashNothing)
{
    EXPECT_EQ(
        load(gltf({.nodes = R"([{"mesh":0,"skin":0},{}])",
                   .more = R"(,"skins":[{"joints":[1]},{"joints":[]}],"images":[{"mimeType":"png","uri":"x"},)"
                           R"({"mimeType":"","bufferView":99}],"animations":[{"channels":[{}]}],"textures":[{}])"}))
            .triangles.size(),
        1u);
}

TEST_F(HostileGltf, OffsetsNear2To64AreOutOfRange)
{
    for (const char* number : {"18446744073709551615", "18446744073709551580", "4294967295", "37", "1"}) {
        refuse(gltf({.view = fmt::format(R"("buffer":0,"byteOffset":{},"byteLength":36)", number)}), "bufferViews[0]");
        refuse(gltf({.accessor = fmt::format(
                         R"("bufferView":0,"byteOffset":{},"componentType":5126,"count":3,"type":"VEC3")", number)}),
               "accessors[0]");
    }
    for (const char* stride : {"18446744073709551615", "9223372036854775808", "13"})
        refuse(gltf({.view = fmt::format(R"("buffer":0,"byteLength":36,"byteStride":{})", stride)}), "accessors[0]");
    refuse(gltf({.view = R"("buffer":0,"byteLength":36,"byteStride":4)"}), "4 bytes apart, but take 12");
    refuse(gltf({.view = R"("buffer":0,"byteLength":18446744073709551615)"}), "bufferViews[0]");
    refuse(gltf({.accessor = R"("bufferView":0,"componentType":5126,"count":4294967295,"type":"VEC3")"}),
           "accessors[0]");
    refuse(gltf({.view = R"("buffer":0,"byteLength":-1)"}), "byteLength: is -1");
}

TEST_F(HostileGltf, ChainsOf30000NodesNeedNoStack)
{
    std::string nodes = "[";
    constexpr int links = 30'000;
    for (int i = 0; i < links; ++i) nodes += fmt::format(R"({{"children":[{}],"translation":[1,0,0]}},)", i + 1);
    nodes += R"({"mesh":0}])";
    EXPECT_EQ(load(gltf({.nodes = nodes})).bounds.min.x(), links);
    const std::string targets = R"(,"skins":[{"joints":[0],"skeleton":30000}],"animations":[{"channels":[)"
                                R"({"sampler":0,"target":{"node":30000,"path":"rotation"}}],"samplers":[{}]}])";
    EXPECT_EQ(load(gltf({.nodes = nodes, .more = targets})).triangles.size(), 1u);
    refuse(gltf({.more = R"(,"extras":)" + std::string(30'000, '[') + std::string(30'000, ']')}), "nested deeper");
}

TEST_F(HostileGltf, KeysThatAreGivenTwiceAreRefused)
{
    refuse(gltf({.accessor = R"("bufferView":0,"componentType":5126,"count":3,"count":99999999,"type":"VEC3")"}),
           "'count' is given twice");
    refuse(gltf({.more = R"(,"buffers":[{"uri":"x","byteLength":99999999}])"}), "'buffers' is given twice");
    refuse(gltf({.more = R"(,"buff\u0065rs":[])"}), "'buffers' is given twice");
}

TEST_F(HostileGltf, NodesThatAreNoTreesAreRefused)
{
    refuse(gltf({.nodes = R"([{"children":[1,2]},{"children":[2]},{"mesh":0}])"}), "two parents");
    refuse(gltf({.nodes = R"([{"children":[1,1]},{"mesh":0}])"}), "two parents");
    refuse(gltf({.nodes = R"([{"mesh":0},{"children":[2]},{"children":[1]}])"}), "own ancestors");
    refuse(gltf({.nodes = R"([{"mesh":0,"children":[0]}])"}), "own ancestors");
    refuse(gltf({.nodes = R"([{"mesh":0,"children":[1]}])"}), "nodes[1]");
    refuse(gltf({.more = R"(,"scenes":[{"nodes":[0,0]}])"}), "two parents");
    refuse(gltf({.more = R"(,"scene":1,"scenes":[{"nodes":[0]}])"}), "scenes[1]");
    refuse(gltf({.nodes = R"([{"mesh":-1}])"}), "nodes[0].mesh: is -1");
    refuse(gltf({.nodes = R"([{"mesh":0,"children":{"a":1}}])"}), "nodes[0].children: is an object, must be an array");
    refuse(gltf({.more = R"(,"scenes":[{"nodes":7}])"}), "scenes[0].nodes: is a number, must be an array");
    refuse(gltf({.nodes = R"([{"mesh":0,"rotation":[0,0,0,0]}])"}), "no direction");
    refuse(gltf({.nodes = R"([{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,1,0,0,0,1]}])"}), "last row");
    refuse(gltf({.nodes = R"([{"mesh":0,"scale":[1e308,1e308,1e308],"children":[1]},{"mesh":0,"scale":[1e308,1,1]}])"}),
           "");
}

TEST_F(HostileGltf, NamesOfBuffersAreDecodedBeforeTheyAreOpened)
{
    const std::string bytes =
        test::gltf_buffer(make_mesh("m", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}})).substr(12);
    folder_.write("b c%.bin", bytes);
    EXPECT_EQ(load(gltf({.uri = "b%20c%25.bin"})).triangles.size(), 1u);
    ASSERT_EQ(::mkfifo((folder_.path() / "pipe 1").c_str(), 0600), 0);
    std::filesystem::create_directory(folder_.path() / "folder");
    for (const char* uri : {"pipe%201", "pipe 1", "%70ipe%201", "/dev/zero", "%2fdev%2fzero", "folder", ".", ""})
        refuse(gltf({.uri = uri}), "file of a buffer cannot be read");
    refuse(gltf({.uri = "b%00.bin"}), "cannot be read");
    for (const char* uri : {"b%2.bin", "b%", "b%zz"}) refuse(gltf({.uri = uri}), "two hexadecimal digits");
    refuse(gltf({.uri = "http://localhost/b.bin"}), "is an address");
    refuse(gltf({.uri = "data:application/octet-stream,AAAA"}), "base64");
    refuse(gltf({.uri = "data:;base64,AAAA!AAA"}), "'!' is no digit of base64");
    refuse(gltf({.uri = "data:;base64,AAAAA"}), "within a byte");
    refuse(gltf({.uri = "data:;base64,AAAA"}), "truncated: the buffer has 3 of 36 bytes");
}

TEST_F(HostileGltf, RequiredExtensionsThatAreNotKnownAreRefusedByName)
{
    refuse(gltf({.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"}), "'KHR_draco_mesh_compression'");
    refuse(gltf({.more = R"(,"extensionsRequired":["EXT_of_mine"])"}), "'EXT_of_mine'");
    EXPECT_EQ(load(gltf({.more = R"(,"extensionsUsed":["KHR_draco_mesh_compression"],)"
                                 R"("extensionsRequired":["KHR_materials_unlit"])"}))
                  .triangles.size(),
              1u);
}

TEST_F(HostileGltf, SmallFilesThatPlaceAMeshAMillionTimesAreBounded)
{
    const test::TemporaryFolder folder;
    std::string nodes = "[";
    for (int i = 0; i < 2'000; ++i) nodes += R"({"mesh":0},)";
    nodes += R"({"mesh":0}])";
    const std::string glb = test::as_glb(make_torus_mesh(2, 0.7, 20'000), nodes.substr(1, nodes.size() - 2));
    // The scene contains only nodes[0]: renames it, so that all nodes are read.
    std::string all = glb;
    all.replace(all.find("scenes"), 6, "scenex"), all.replace(all.find("\"scene\""), 7, "\"scenf\"");
    const auto path = folder.write("a.glb", all);
    const auto start = std::chrono::steady_clock::now();
    expect_error(
        ErrorKind::bad_data, [&] { load_mesh(path); }, path.string(), "more than 10000000 triangles");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
    // Vertices that are in no buffer are not created unless a triangle uses them.
    const std::string sparse = R"("componentType":5126,"count":4000000000,"type":"VEC3","sparse":{"count":3,"indices":)"
                               R"({"bufferView":1,"componentType":5125},"values":{"bufferView":0}})";
    const std::string views = R"(,{"buffer":1,"byteLength":12},{"buffer":2,"byteLength":12})";
    Parts parts{.views = views, .view = R"("buffer":0,"byteLength":36)", .accessor = sparse};
    parts.accessors = R"(,{"bufferView":2,"componentType":5125,"count":3,"type":"SCALAR"})";
    parts.primitive = R"(,"indices":1)";
    std::string text = gltf(parts);
    // places 0, 1 and 3999999999; triangle 0, 1, 3999999999
    const std::string buffers = R"(,{"uri":"data:;base64,AAAAAAEAAAD/J2vu","byteLength":12})";
    text.insert(text.rfind("]"), buffers + buffers);
    EXPECT_EQ(load(text).vertices, (std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST_F(HostileGltf, StripsFansSparseAndQuantizedPositionsAreRead)
{
    // Square corners (0,0), (1,0), (0,1), (1,1) as floats in the plane z = 0.
    const Mesh square = make_mesh("s", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {2, 1, 3}});
    folder_.write("s.bin", test::gltf_buffer(square).substr(24));
    Parts parts{.uri = "s.bin",
                .view = R"("buffer":0,"byteLength":48)",
                .accessor = R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")",
                .bytes = 48};
    parts.primitive = R"(,"mode":5)";
    EXPECT_EQ(load(gltf(parts)).triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
    parts.primitive = R"(,"mode":6)";
    const Mesh fan = load(gltf(parts)); // welded in the order of first use: 1, 2, 0, 3
    EXPECT_EQ(fan.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
    EXPECT_EQ(fan.vertices[0], Vector3d(1, 0, 0));
    parts.primitive = R"(,"mode":0)";
    refuse(gltf(parts), "no triangle");

    // Signed normalised bytes: 127 is 1.
    std::string bytes;
    for (const int v : {0, 0, 0, 0, 127, 0, 0, 0, -128, 0, 127, 0}) bytes += static_cast<char>(v);
    folder_.write("q.bin", bytes);
    Parts quantized{.uri = "q.bin",
                    .view = R"("buffer":0,"byteLength":12,"byteStride":4)",
                    .accessor = R"("bufferView":0,"componentType":5120,"normalized":true,"count":3,"type":"VEC3")",
                    .bytes = 12};
    refuse(gltf(quantized), "not made of three floats");
    quantized.more = R"(,"extensionsRequired":["KHR_mesh_quantization"])";
    EXPECT_EQ(load(gltf(quantized)).vertices, (std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {-1, 0, 1}}));

    const std::string sparse = R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,)"
                               R"("indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}})";
    const auto with_place = [&](int place) {
        std::string numbers;
        for (const auto& p : {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(7, 8, 9)})
            for (int axis = 0; axis < 3; ++axis) test::append(numbers, static_cast<float>(p[axis]));
        folder_.write("v.bin", numbers + static_cast<char>(place));
        return gltf(
            {.uri = "v.bin",
             .views = R"(,{"buffer":0,"byteOffset":48,"byteLength":1},{"buffer":0,"byteOffset":36,"byteLength":12})",
             .accessor = sparse,
             .bytes = 49});
    };
    EXPECT_EQ(load(with_place(1)).vertices[1], Vector3d(7, 8, 9));
    refuse(with_place(3), "must ascend");
}

TEST_F(HostileGltf, MutationsOfTheStructureGiveAMeshOrOneError)
{
    using nlohmann::json;
    Parts parts{.nodes = R"([{"children":[1,2],"scale":[1,-2,3]},{"mesh":0,"rotation":[0,0,0.6,0.8]},)"
                         R"({"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]}])",
                .more = R"(,"scene":0,"scenes":[{"nodes":[0]}],"extensionsUsed":["KHR_mesh_quantization"])"};
    parts.views = R"(,{"buffer":0,"byteOffset":34,"byteLength":2},{"buffer":0,"byteOffset":12,"byteLength":12})";
    parts.accessor +=
        R"(,"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}})";
    const json valid = json::parse(gltf(parts));
    std::vector<json> drawn = {0,  1,  2,   3,     4,  11,      12,   13,     35,      36,
                               37, -1, 1.5, 1e308, "", nullptr, true, "VEC3", "SCALAR"};
    for (const int shift : {8, 16, 31, 32, 53, 63}) drawn.push_back(std::uint64_t(1) << shift);
    for (const std::uint64_t below : {1, 12, 36}) drawn.push_back(0 - below);
    for (int type = 5120; type <= 5126; ++type) drawn.push_back(type);
    drawn.push_back(json::array()), drawn.push_back(json::object());

    int accepted = 0;
    constexpr int rounds = 4000;
    const test::StructureMutator mutated(valid, drawn);
    for (int round = 0; round < rounds; ++round) {
        const auto path = folder_.write("a.gltf", mutated(std::uint64_t(round)).dump());
        try {
            const Mesh mesh = load_mesh(path);
            EXPECT_NO_THROW(make_mesh("again", mesh.vertices, mesh.triangles));
            ++accepted;
        } catch (const Error& error) {
            EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(ErrorKind::bad_data)) << error.what();
            EXPECT_TRUE(std::string(error.what()).starts_with(path.string() + ": ")) << error.what();
        }
    }
    EXPECT_GT(accepted, rounds / 20);
    EXPECT_LT(accepted, rounds / 2);
}

} // namespace
} // namespace oncollide
