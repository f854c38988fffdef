// FCL and oncollide on the same scene, in alternation, frame by frame.
#include "bench/bench.hpp"

#include <algorithm>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>

#include "bench/scenes/scene_report.hpp"
#include "cli/shard.hpp"

namespace oncollide::tools {

int bench_scene(const CompareOptions& given)
{
    CompareOptions options = given;
    if (!options.only.empty() && options.only != "fcl" && options.only != "oncollide")
        usage(fmt::format("--only {}: valid are fcl, oncollide", options.only));
    check_range("--warm-up", options.warm_up, 0), check_range("--repeats", options.repeats, 1, 1000);
    check_range("--cold-runs", options.cold_runs, 1, 100);
    check_files({{"--csv", options.csv}, {"--summary", options.summary}});
    options.scene.on_demand = options.only == "oncollide"; // FCL needs whole meshes
    if (!options.scene.cache.folder.empty() && !options.scene.on_demand)
        usage("--cache: needs --only oncollide; FCL needs whole meshes in memory");
    const Settings settings = settings_from(options.settings);
    if (options.contacts && exact_level(settings) != ExactLevel::predicates)
        usage("--contacts: needs --exact predicates");
    Scene scene = open_scene(options.scene);
    const Shard shard = shard_from(options.shard);
    check_parts(shard, std::size_t(scene.frames), "frames");
    const auto [begin, end] = shard.range(std::size_t(scene.frames));
    options.warm_up = std::min(options.warm_up, int(end - begin) - 1);
    print_warnings(scene);
    const SceneRuns runs = race(options, settings, scene);
    const SceneReport report(options, settings, scene, runs);
    const std::uint64_t faults = report.print();
    if (!options.csv.empty()) report.write_csv();
    if (!options.summary.empty()) report.write_summary();
    return faults ? int(ErrorKind::internal) : 0;
}

} // namespace oncollide::tools
