// Commands with scenes whose meshes deform.
#include "tools/view_fixture.hpp"

#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide::test {
namespace {

class DeformingScene : public View {
protected:
    Outcome flags(std::vector<std::string> more)
    {
        more.insert(more.begin(), {"run", "flags", "--bodies", "40", "--frames", "60"});
        return run(std::move(more));
    }
    static std::string hash(const Outcome& outcome)
    {
        const std::size_t begin = outcome.out.rfind("hash");
        return outcome.out.substr(begin, outcome.out.find('\n', begin) - begin);
    }
    /// A cloth of two triangles that falls by 1 m per frame through a ball at z = -3, as a scene and its vertices.
    void write_cloth(const std::string& vertices)
    {
        folder_.write("cloth.json", R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 0.2}},
            "cloth": {"mesh": {"vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
                               "triangles": [[0, 1, 2], [0, 2, 3]]}, "deformation": {"file": "v.npy"}}},
            "bodies": [{"name": "cloth", "geometry": "cloth"}, {"name": "ball", "geometry": "ball", "position": [0, 0, -3]}]})");
        folder_.write("v.npy", vertices);
    }
    /// @param change  applied to vertex 2 of frame 4
    static std::string falling(const std::function<double(double)>& change = {})
    {
        std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (7, 4, 3), }";
        header.resize(117, ' '), header += '\n';
        std::string bytes = std::string("\x93NUMPY\x01\0", 8) + char(header.size()) + '\0' + header;
        for (int f = 0; f < 7; ++f)
            for (int v = 0; v < 4; ++v)
                for (double x : {v == 1 || v == 2 ? 1.0 : -1.0, v > 1 ? 1.0 : -1.0, -1.0 * f}) {
                    const auto number = float(change && f == 4 && v == 2 ? change(x) : x);
                    char raw[sizeof number];
                    std::memcpy(raw, &number, sizeof number);
                    bytes.append(raw, sizeof number);
                }
        return bytes;
    }
};

TEST_F(DeformingScene, OfTheCatalogueGivesTheSameResultsEachTime)
{
    const Outcome once = flags({"--csv", "a.csv"}), again = flags({"--csv", "b.csv", "--threads", "3"});
    ASSERT_EQ(once.code, 0) << once.err;
    EXPECT_EQ(hash(once), hash(again));
    EXPECT_EQ(folder_.read("a.csv"), folder_.read("b.csv"));
    EXPECT_NE(folder_.read("a.csv").find("flag-"), std::string::npos);
    EXPECT_EQ(flags({"--exit-code", "--quiet"}).code, 1);
    ASSERT_EQ(run({"scene", "flags", "--bodies", "40", "--frames", "60", "--out", "flags.json"}).code, 0);
    EXPECT_EQ(hash(run({"run", "flags.json"})), hash(once));
    EXPECT_EQ(hash(flags({"--checkpoint", "c", "--csv", "c.csv"})), hash(once));
    EXPECT_EQ(folder_.read("c.csv"), folder_.read("a.csv"));
    std::vector<std::string> merge{"merge", "--out", "d.csv"};
    for (const char* part : {"1/3", "2/3", "3/3"}) {
        merge.push_back(std::string(1, part[0]) + ".csv");
        EXPECT_EQ(flags({"--quiet", "--shard", part, "--csv", merge.back()}).code, 0);
    }
    EXPECT_EQ(run(merge).code, 0);
    EXPECT_EQ(folder_.read("d.csv"), folder_.read("a.csv"));
}

TEST_F(DeformingScene, IsRefusedWhereItsResultsWouldNotHold)
{
    const std::vector<std::string> scene{"run", "flags", "--bodies", "8", "--frames", "4"};
    const auto refuse = [&](std::vector<std::string> more, const std::vector<std::string>& words) {
        more.insert(more.begin(), scene.begin(), scene.end());
        expect_error(64, more, words);
    };
    refuse({"--continuous"}, {"geometry 'flag 0' deforms", "--continuous", "--pace 0.1"});
    refuse({"--continuous", "--checkpoint", "c"}, {"geometry 'flag 0' deforms", "--continuous"});
    refuse({"--max-error", "0.01", "--checkpoint", "c"}, {"geometry 'flag 0' deforms", "--exact on"});
    expect_error(64, {"accuracy", "study", "flags", "--bodies", "8", "--frames", "4"}, {"'flag 0' deforms", "run"});
}

TEST_F(DeformingScene, OfRecordedVerticesCollidesWhereTheyAre)
{
    write_cloth(falling());
    const Outcome outcome = run({"run", "cloth.json", "--csv", "x.csv"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("7 frames"), std::string::npos);
    const std::string rows = folder_.read("x.csv");
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 2) << rows;
    EXPECT_NE(rows.find("\n3,cloth,ball,colliding,"), std::string::npos) << rows;
}

TEST_F(DeformingScene, OfWrongVerticesIsOneErrorAfterTheFramesBefore)
{
    write_cloth(falling([](double) { return std::nan(""); }));
    const Outcome outcome = run({"run", "cloth.json", "--quiet", "--csv", "x.csv"});
    EXPECT_EQ(outcome.code, 65);
    EXPECT_NE(outcome.err.find("v.npy: frame 4: vertex 2: (nan, nan, nan) is not finite"), std::string::npos)
        << outcome.err;
    EXPECT_NE(folder_.read("x.csv").find("\n3,cloth,ball,colliding,"), std::string::npos);
    folder_.write("v.npy", falling().substr(0, 200));
    expect_error(65, {"run", "cloth.json"}, {"cloth.json: geometries.cloth.deformation: ", "v.npy: ", "announced"});
    std::filesystem::remove(folder_ / "v.npy");
    expect_error(66, {"run", "cloth.json"}, {"cloth.json: geometries.cloth.deformation: ", "v.npy"});
}

TEST_F(DeformingScene, HasItsVerticesOfEachFrameOnThePage)
{
    const Outcome outcome = run_without_three({"run", "flags", "--bodies", "1", "--frames", "9", "--view", "x.html"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json of_page = header().at("geometries");
    EXPECT_EQ(of_page[0].at("deforms"), true);
    EXPECT_EQ(of_page[0].at("meshes"), nlohmann::json::parse("[[651, 1200]]")) << "one level of detail";
    EXPECT_FALSE(of_page[1].contains("deforms")) << "a flag that no body uses";
    EXPECT_FALSE(of_page[0].contains("boxes")) << "trees of one frame would be wrong in the others";

    Scene scene = make_scene("flags", {.bodies = 1});
    const std::string bytes = decoded_base64(block("m0.0"));
    std::vector<std::uint16_t> indices(3 * 1200);
    std::memcpy(indices.data(), bytes.data() + 6 * 651, 2 * indices.size());
    Mover mover;
    for (const int frame : {0, 4, 8}) {
        mover.move(scene, frame);
        const Mesh& mesh = std::get<Mesh>(scene.geometries[0].data);
        const std::string columns = decoded_base64(block(fmt::format("f{}", frame)));
        std::array<double, 6> box;
        std::memcpy(box.data(), columns.data(), sizeof box);
        EXPECT_EQ(Eigen::Vector3d::Map(&box[0]), mesh.bounds.min);
        EXPECT_EQ(Eigen::Vector3d::Map(&box[3]), mesh.bounds.max);
        std::vector<std::uint16_t> vertices(3 * 651); // neither poses nor pairs are before them
        std::memcpy(vertices.data(), columns.data() + sizeof box, 2 * vertices.size());
        for (std::size_t c = 0; c < indices.size(); ++c) {
            const Eigen::Vector3d expected = mesh.vertices[mesh.triangles[c / 3][c % 3]];
            for (int k = 0; k < 3; ++k) {
                const double size = box[std::size_t(3 + k)] - box[std::size_t(k)];
                ASSERT_NEAR(box[std::size_t(k)] + size * vertices[std::size_t(3 * indices[c] + k)] / 65535, expected[k],
                            0.51 * size / 65535)
                    << frame << ", corner " << c;
            }
        }
    }
}

TEST_F(DeformingScene, OfManyVerticesIsShownSimplifiedAndFrameByFrame)
{
    folder_.write("s.json",
                  R"({"frames": 20, "geometries": {"cloth": {"mesh": {"generate": {"kind": "sheet", "size": [2, 2],
        "cells": [200, 200]}}, "deformation": {"flutter": {"edge": [-1, 0, 0], "along": [1, 0, 0], "normal": [0, 0, 1],
        "growth": 0.1, "waves": [[0.8, 1, 10, 0.2, 0]]}}}}, "bodies": [{"geometry": "cloth"}]})");
    const Outcome outcome = run_without_three({"run", "s.json", "--view", "x.html", "--view-limit", "2"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("20 frames; 1 geometry shown simplified"), std::string::npos) << outcome.err;
    EXPECT_LT(folder_.read("x.html").size(), 2'000'000u);
    const nlohmann::json mesh = header().at("geometries")[0].at("meshes")[0];
    EXPECT_GT(mesh[1], 2'000);
    EXPECT_LT(mesh[1], 20'000);
    EXPECT_EQ(decoded_base64(block("f7")).size(), 48 + 6 * mesh[0].get<std::size_t>());
}

TEST_F(DeformingScene, OfStoredResultsIsThePageOfTheRun)
{
    write_cloth(falling());
    if (run({"run", "cloth.json", "--quiet", "--pairs", "p.h5"}).code == 64) GTEST_SKIP() << "skipped: no HDF5";
    std::filesystem::remove(folder_ / "p.h5");
    ASSERT_EQ(run_without_three({"run", "cloth.json", "--quiet", "--pairs", "p.h5", "--view", "x.html"}).err, "");
    ASSERT_EQ(run_without_three({"view", "p.h5", "-o", "y.html", "--quiet"}).err, "");
    ASSERT_EQ(run_without_three({"view", "p.h5", "-o", "z.html", "--quiet", "--from-frame", "3"}).err, "");
    for (int f = 0; f < 7; ++f) EXPECT_EQ(block(fmt::format("f{}", f), "y.html"), block(fmt::format("f{}", f))) << f;
    for (int f = 3; f < 7; ++f) EXPECT_EQ(block(fmt::format("f{}", f - 3), "z.html"), block(fmt::format("f{}", f)));
}

TEST_F(DeformingScene, IsDrawnAsItIsInEachFrame)
{
    write_cloth(falling());
    const auto picture = [&](const char* file, const char* frames) {
        const Outcome outcome = run({"render", "cloth.json", "--rays", "--quiet", "--size", "160x120", "--eye",
                                     "0 -9 0", "--look-at", "0 0 -3", "--frame", frames, "--out", file});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return folder_.read(file);
    };
    EXPECT_NE(picture("a.png", "0"), picture("b.png", "5"));
    EXPECT_EQ(picture("c.png", "0"), picture("d.png", "0"));
}

} // namespace
} // namespace oncollide::test
