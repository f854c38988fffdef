// Mesh files that are missing, damaged or of no known kind.
#include <chrono>
#include <cmath>
#include <numbers>

#include <oncollide/base/files/system_file.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>

#include "scenes/files/mesh_samples.hpp"

namespace oncollide::mesh_file_test {
namespace {

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
    no_input(null_device, "not a readable file");
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

} // namespace
} // namespace oncollide::mesh_file_test
