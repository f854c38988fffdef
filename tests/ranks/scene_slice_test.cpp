// Scenes that are read and made in slices: each rank gets its own bodies, and no rank gets all.
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/runs/ranks/ranked_run.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "cooked_bytes.hpp"
#include "tools/run_command.hpp"

namespace oncollide {
namespace {

/// Makes the scene whole, or without its bodies, which go to a sink.
struct MakeScene {
    std::function<Scene()> whole;
    std::function<SceneInfo(BodySink&)> passed;
};

std::vector<Bytes> bytes_of(const SceneSlice& slice)
{
    std::vector<Bytes> all;
    for (const BodyRecord& record : slice.records) put(all.emplace_back(), record);
    return all;
}

/// The slices of all ranks must add up to the whole scene, and each rank must receive only its share.
void expect_slices(const MakeScene& make)
{
    const Scene whole = make.whole();
    SCOPED_TRACE(whole.name);
    for (const int size : {1, 2, 5}) {
        std::size_t bodies = 0;
        for (int rank = 0; rank < size; ++rank) {
            SliceReader reader(rank, size, true);
            const SceneSlice slice = reader.finish(make.passed(reader)), expected = slice_of(whole, rank, size, true);
            EXPECT_EQ(bytes_of(slice), bytes_of(expected)) << rank << " of " << size;
            EXPECT_EQ(slice.bodies, whole.size());
            EXPECT_EQ(slice.common, expected.common);
            EXPECT_EQ(slice.own, expected.own);
            EXPECT_EQ(slice.other, expected.other);
            EXPECT_LE(slice.records.size(), whole.size() / std::size_t(size) + 1024);
            bodies += slice.records.size();
        }
        EXPECT_EQ(bodies, whole.size());
    }
}

TEST(SceneSlice, OfTheCatalogueIsMadeFromTheIndicesOfItsBodies)
{
    const auto made = [](const char* name, std::optional<int> bodies) {
        const CatalogueOptions options{.bodies = bodies, .frames = 3, .data = {}};
        expect_slices({[&] { return make_scene(name, options); },
                       [&](BodySink& sink) { return make_scene(name, sink, options); }});
    };
    for (const char* name :
         {"many", "city", "swarm", "boxes", "octomap", "hills", "random", "chunks", "st-helens", "flags"})
        made(name, 3000);
    made("hard", {});
}

TEST(SceneSlice, OfFilesIsReadFromTheirRows)
{
    const test::TemporaryFolder folder;
    std::string table = "name,x,y,z,vx,vy,vz\n", list;
    for (int i = 0; i < 30'000; ++i)
        table += fmt::format("\"row \"\"{0}\"\"\",{0},0,1,{1},0,0\n", i, i % 3 == 0 ? 1 : 0);
    for (int i = 0; i < 1500; ++i)
        list += fmt::format(R"({}{{"geometry": "ball", "position": [{}, 3, 4]}})", i ? "," : "", i);
    folder.write("t.csv", table.substr(0, table.size() - 1)); // the last line has no line end
    const std::string begin = R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 0.6}}}, "bodies": [)" +
                              list + R"(], "tables": [{"file": "t.csv", "geometry": "ball"},
        {"file": "u.csv", "geometry": "ball"}])";
    folder.write("u.csv", "x,y,z\n1,2,3\n");
    folder.write("numbers.json", begin + R"(, "exclude": [[0, 1], [7, 1500], [1500, 30000]]})");
    folder.write("names.json", begin + R"(, "exclude": [["row \"4\"", 3], ["row \"20000\"", "row \"20001\""]]})");
    for (const char* file : {"numbers.json", "names.json"})
        expect_slices({[&] { return load_scene(folder / file); },
                       [&](BodySink& sink) { return load_scene(folder / file, sink); }});
    SliceReader reader(0, 2, false);
    EXPECT_EQ(load_scene(folder / "numbers.json", reader).size(), 31'501u);
}

std::string refused(const std::function<void(Ranks&)>& work, int size)
{
    try {
        run_ranks_on_threads(size, work);
        return "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        return error.what();
    }
}

TEST(SceneSlice, ErrorsInRowsAreThoseOfTheRankThatReadsThem)
{
    const test::TemporaryFolder folder;
    folder.write("s.json", R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}},
        "tables": [{"file": "t.csv", "geometry": "ball"}]})");
    const auto read = [&](Ranks& ranks) {
        SceneSlice slice;
        together(ranks, [&] {
            SliceReader reader(ranks.rank(), ranks.size(), true);
            slice = reader.finish(load_scene(folder / "s.json", reader));
        });
        RankedRun(ranks, make_morton_partitioner(), std::move(slice), {});
    };
    const auto table = [&](int line, const char* wrong) {
        std::string text = "x,y,z,name\n";
        for (int i = 2; i < 5000; ++i)
            text += i == line ? std::string(wrong) + "\n" : fmt::format("{},2,3,body {}\n", i, i);
        folder.write("t.csv", text);
    };
    for (const int line : {2, 1500, 3000, 4999}) {
        table(line, "1,2,nan,x");
        EXPECT_NE(refused(read, 3).find(fmt::format("t.csv: line {}: column 'z'", line)), std::string::npos)
            << refused(read, 3);
        table(line, "1,2");
        EXPECT_NE(refused(read, 3).find(fmt::format("t.csv: line {}: has 2 fields", line)), std::string::npos);
    }
    table(4000, "1,2,3,body 7");
    EXPECT_NE(refused(read, 3).find("body 3998: has the same name as body 5"), std::string::npos) << refused(read, 3);
}

TEST(SceneSlice, WhatOneRankAloneReadsOtherwiseIsFound)
{
    const auto scene_of = [](int other) {
        Scene scene;
        scene.add("ball", Sphere{1});
        for (int i = 0; i < 9000; ++i) {
            BodyInit body{.geometry = GeometryId{0}};
            body.pose.translation().x() = i == other ? -1 : 3 * i;
            scene.add_body(body);
        }
        return scene;
    };
    const Scene good = scene_of(-1);
    for (const int body : {0, 1024, 5000, 8999}) {
        const Scene wrong = scene_of(body);
        const int reader = body / 1024 % 4;
        const auto read = [&](Ranks& ranks) {
            const Scene& scene = ranks.rank() == reader ? wrong : good;
            RankedRun(ranks, make_morton_partitioner(), slice_of(scene, ranks.rank(), 4, false), {});
        };
        EXPECT_NE(refused(read, 4).find("different scenes"), std::string::npos) << body;
    }
}

/// A cooked file whose chunks are all damaged: faults() then counts the chunks that were read.
TEST(SceneSlice, ChunksOfAGiantAreTouchedWhereBodiesAreAlone)
{
    const test::TemporaryFolder folder;
    cook_mesh(make_terrain_mesh(200, 2, 300, 3), folder / "ground.cooked");
    std::string bytes = folder.read("ground.cooked");
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    ASSERT_GT(header.chunks, 40u);
    for (std::uint32_t c = 0; c < header.chunks; ++c) {
        const auto entry =
            test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes) + c * sizeof(CookedChunkEntry));
        bytes[entry.offset + entry.bytes / 2] ^= 1;
    }
    folder.write("ground.cooked", bytes);
    const auto touched = [&](int rank, int size, Ranks& ranks) {
        const auto ground = std::make_shared<const CookedMesh>(folder / "ground.cooked");
        Scene scene;
        scene.frames = 2;
        scene.add_body({.geometry = scene.add("ground", ground), .is_static = true});
        const GeometryId ball = scene.add("ball", Sphere{0.5});
        for (std::uint64_t i = 0; i < 60; ++i) { // in two opposite corners
            const double corner = i % 2 ? 70 : -70;
            BodyInit body{.geometry = ball, .motion = Drift{.velocity = {0.1, 0, 0}, .walls = {}}};
            body.pose.translation() = Eigen::Vector3d(corner + 8 * u01(1, i, 0), corner + 8 * u01(1, i, 1), 0.5);
            scene.add_body(body);
        }
        RankedRun run(ranks, make_morton_partitioner(), slice_of(scene, rank, size, false), {.max_error = 0.05});
        while (run.frame() < scene.frames) run.step();
        return ground->faults();
    };
    std::vector<std::string> of_one;
    run_ranks_on_threads(1, [&](Ranks& ranks) { of_one = touched(0, 1, ranks); });
    for (const int size : {2, 4}) {
        std::vector<std::vector<std::string>> of_rank(static_cast<std::size_t>(size));
        run_ranks_on_threads(
            size, [&](Ranks& ranks) { of_rank[std::size_t(ranks.rank())] = touched(ranks.rank(), size, ranks); });
        std::vector<std::string> all;
        for (auto& chunks : of_rank) {
            EXPECT_LT(chunks.size(), of_one.size()) << size;
            all.insert(all.end(), chunks.begin(), chunks.end());
        }
        std::ranges::sort(all), std::ranges::sort(of_one);
        all.erase(std::unique(all.begin(), all.end()), all.end());
        EXPECT_EQ(all, of_one) << size;
    }
    EXPECT_GT(of_one.size(), 3u);
    EXPECT_LT(of_one.size(), header.chunks / 2);
}

} // namespace
} // namespace oncollide
