// Scenes played by many ranks, which are threads of this process that share no more data than processes do.
#pragma once
#include <functional>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/ranks/ranked_run.hpp>
#include <oncollide/runs/report.hpp>
#include <oncollide/samples/catalogue.hpp>

#include "tools/run_command.hpp"

namespace oncollide {
namespace ranks_test {

using Eigen::Vector3d;
using test::TemporaryFolder;

struct Played {
    std::uint64_t hash = 0;
    std::array<std::uint64_t, 4> verdicts{};
    std::string csv;
    friend bool operator==(const Played&, const Played&) = default;
};
inline void PrintTo(const Played& played, std::ostream* out)
{
    *out << std::hex << played.hash << std::dec << ", " << played.csv.size() << " bytes of rows; verdicts";
    for (const std::uint64_t count : played.verdicts) *out << " " << count;
}

using MakePartitioner = std::function<std::unique_ptr<Partitioner>()>;

class RanksTest : public ::testing::Test {
protected:
    Played by_one(Scene scene, const Settings& settings = {}, bool continuous = false) const
    {
        Mover mover;
        mover.move(scene, 0);
        Pipeline pipeline(scene, settings);
        pipeline.set_continuous(continuous);
        WorldAccess::parts_by_poses(pipeline.world());
        Report report(scene, pipeline, {.json = false, .csv = true, .trace = false, .folder = {}});
        for (int frame = 0; frame < scene.frames; ++frame) {
            mover.move(scene, frame);
            report.add(pipeline.step(scene));
        }
        report.write_csv(folder_ / "one.csv");
        return {pipeline.hash(), report.verdicts(), folder_.read("one.csv")};
    }
    Played by_many(const Scene& scene, int size, const Settings& settings = {}, RankedOptions options = {},
                   const MakePartitioner& partitioner = &make_morton_partitioner, int stop_after = 1 << 30) const
    {
        Played played;
        options.csv = folder_ / "many.csv";
        run_ranks_on_threads(size, [&](Ranks& ranks) {
            RankedRun run(ranks, partitioner(), slice_of(scene, ranks.rank(), size, true), settings, options);
            while (run.frame() < std::min(scene.frames, stop_after)) run.step();
            if (run.frame() == scene.frames) run.finish();
            const std::uint64_t hash = run.hash();
            const auto verdicts = run.verdicts();
            if (ranks.rank() == 0) played.hash = hash, played.verdicts = verdicts;
        });
        if (stop_after > scene.frames) played.csv = folder_.read("many.csv");
        return played;
    }
    void expect_the_same(const Scene& scene, const Settings& settings = {})
    {
        const Played one = by_one(scene, settings);
        for (const int size : {1, 2, 3, 4, 7})
            EXPECT_EQ(by_many(scene, size, settings), one) << size << " ranks, " << scene.name;
        for (const int size : {2, 4, 7}) {
            const Rebalance rebalance = size == 4 ? Rebalance::never : Rebalance::always;
            EXPECT_EQ(by_many(scene, size, settings, {.rebalance = rebalance}), one) << size << ", " << scene.name;
        }
    }

    TemporaryFolder folder_;
};

inline void expect_refused(ErrorKind kind, const std::string& words, const std::function<void()>& call)
{
    try {
        call();
        ADD_FAILURE() << "no error: " << words;
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), kind) << error.what();
        EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
}

inline Scene catalogue_scene(const char* name, std::optional<int> bodies, int frames)
{
    return make_scene(name, {.bodies = bodies, .frames = frames, .data = {}});
}

} // namespace ranks_test
} // namespace oncollide
