// FCL and oncollide on the same scene, in alternation, frame by frame.

#include <algorithm>

#include "bench/scenes/scene_race.hpp"
#include "render/backend_trial.hpp"

namespace oncollide::tools {

namespace {

/// Plays a scene with both libraries. Returns the exit code: 70 if oncollide missed a collision.
int bench_scene(const CompareOptions& given)
{
    CompareOptions options = given;
    if (!options.only.empty() && options.only != "fcl" && options.only != "oncollide")
        usage(fmt::format("--only {}: valid are fcl, oncollide", options.only));
    options.scene.on_demand = options.only == "oncollide"; // FCL needs whole meshes
    if (!options.scene.cache.folder.empty() && !options.scene.on_demand)
        usage("--cache: needs --only oncollide; FCL needs whole meshes in memory");
    const Settings settings = with_tried_backend(settings_from(options.settings));
    if (options.contacts && exact_level(settings) != ExactLevel::predicates)
        usage("--contacts: needs --exact predicates");
    Scene scene = open_scene(options.scene);
    must_be_rigid(scene, "bench scene");
    const Shard shard = shard_from(options.shard);
    check_parts(shard, std::size_t(scene.frames), "frames");
    const auto [begin, end] = shard.range(std::size_t(scene.frames));
    options.warm_up = std::min(options.warm_up, int(end - begin) - 1);
    print_warnings(scene);
    const SceneRuns runs = race(options, settings, scene);
    return code_of(report(options, settings, scene, runs) > 0);
}

void add_compare_options(Benchmark<CompareOptions>& b)
{
    b->repeats = 1;
    add_catalogue_options(b.arguments(), b->scene), add_pace_option(b.arguments(), b->scene);
    add_cache_options(b.arguments(), b->scene.cache);
    add_accuracy_options(b.arguments(), b->settings);
    add_pipeline_options(b.arguments(), b->settings);
    b.whole("--warm-up N", b->warm_up, "frames at the start that are not timed", {0});
    b.repeats("number of runs from frame 0; each frame's least time counts");
    b.whole("--cold-runs N", b->cold_runs, "number of cold starts, from the scene to the first frame's results",
            {1, 100});
    b.option("--only WHO", b->only, "run only fcl or only oncollide, to measure its memory");
    b.flag("--contacts", b->contacts,
           "find all contacts of each colliding pair, not only whether it collides; needs exact results");
    b.option("--timeline N", b->timeline, "print a line every N frames: cells alive, pairs, times");
    b.csv("frame");
    b.output("--summary", "FILE", b->summary, "write one row: time of the first result, time per frame, memory");
    b.shard("frames");
}

} // namespace

void add_scene_bench(Arguments bench, const char* name, const char* summary)
{
    Benchmark<CompareOptions> b(bench, name, summary, bench_scene);
    b->scene.scene = name;
    add_compare_options(b);
}

void add_any_scene_bench(Arguments bench)
{
    Benchmark<CompareOptions> b(bench, "scene", "Any scene: a file or a scene of the catalogue", bench_scene);
    b.option("scene SCENE.json|NAME", b->scene.scene, "scene file, or a name from 'oncollide scene --list'").required();
    add_compare_options(b);
}

} // namespace oncollide::tools
