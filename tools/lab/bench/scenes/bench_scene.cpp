// FCL and oncollide on the same scene, in alternation, frame by frame.
#include "bench/bench.hpp"
#include "cli/options.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>

#include "bench/scenes/scene_report.hpp"
#include "cli/shard.hpp"
#include "render/backend_trial.hpp"

namespace oncollide::tools {

namespace {

/// Plays a scene with both libraries. Returns the exit code: 70 if oncollide missed a collision.
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
    const Settings settings = with_tried_backend(settings_from(options.settings));
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

void add_compare_options(Arguments sub, CompareOptions& o)
{
    add_catalogue_options(sub, o.scene), add_pace_option(sub, o.scene);
    add_cache_options(sub, o.scene.cache);
    add_accuracy_options(sub, o.settings);
    add_pipeline_options(sub, o.settings);
    sub.add_option("--warm-up N", o.warm_up, "frames at the start that are not timed (default 3)");
    sub.add_option("--repeats N", o.repeats, "number of runs from frame 0; each frame's least time counts");
    sub.add_option("--cold-runs N", o.cold_runs,
                   "number of cold starts, from the scene to the first frame's results (default 5)");
    sub.add_option("--only WHO", o.only, "run only fcl or only oncollide, to measure its memory");
    sub.add_flag("--contacts", o.contacts,
                 "find all contacts of each colliding pair, not only whether it collides; needs exact results");
    sub.add_option("--timeline N", o.timeline, "print a line every N frames: cells alive, pairs, times");
    sub.add_option("--csv FILE", o.csv, "write one row per frame");
    sub.add_option("--summary FILE", o.summary, "write one row: time of the first result, time per frame, memory");
    sub.add_option("--shard I/N", o.shard, std::string("divide the frames among N processes: ") + shard_help);
}

} // namespace

void add_scene_bench(Arguments bench, const char* name, const char* summary)
{
    Arguments sub = bench.add_command(name, summary);
    auto options = std::make_shared<CompareOptions>();
    options->scene.scene = name;
    add_compare_options(sub, *options);
    sub.action([options] { return bench_scene(*options); });
}

void add_any_scene_bench(Arguments bench)
{
    Arguments sub = bench.add_command("scene", "Any scene: a file or a scene of the catalogue");
    auto options = std::make_shared<CompareOptions>();
    sub.add_option("scene SCENE.json|NAME", options->scene.scene, "scene file, or a name from 'oncollide scene --list'")
        .required();
    add_compare_options(sub, *options);
    sub.action([options] { return bench_scene(*options); });
}

} // namespace oncollide::tools
