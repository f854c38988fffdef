#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/shard.hpp"
#include "play/compared.hpp"
#include "play/pairs_file.hpp"
#include "play/play_ranks.hpp"

#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "render/backend_trial.hpp"
#include "view/view_page.hpp"

#include <oncollide/base/threads/parallel.hpp>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/deforming_models.hpp>

namespace oncollide::tools {
namespace {

struct RunOptions {
    SceneOptions scene;
    SettingsOptions settings;
    OutputOptions outputs;
    std::string view;
    int view_limit = 40; ///< MB
    int from_frame = 0;
    RankOptions ranks;
    std::string shard;
    bool exit_code = false;
    bool continuous = false;
};

/// The page of --view; null: not requested.
std::unique_ptr<ViewPage> view_page(const RunOptions& options, const Scene& scene, const Pipeline& pipeline, int frames)
{
    if (options.view.empty()) return nullptr;
    return std::make_unique<ViewPage>(scene, pipeline,
                                      ViewPage::Options{.file = options.view,
                                                        .most_bytes = std::size_t(options.view_limit) * 1'000'000,
                                                        .separate = options.outputs.separate,
                                                        .frames = std::size_t(frames),
                                                        .threads = thread_count(pipeline.settings())});
}

/// True if a file lists the parts of contacts.
bool lists_pairs(const RunOptions& options)
{
    const OutputOptions& outputs = options.outputs;
    return !(outputs.csv.empty() && outputs.json.empty() && outputs.pairs.empty() && options.view.empty());
}

/// The exit code of --exit-code for the pairs of all frames; `check` has the same codes.
int code_of(const Report& report)
{
    const std::array<std::uint64_t, 4> counts = report.verdicts();
    if (counts[int(Verdict::colliding)]) return 1;
    return counts[int(Verdict::within)] || counts[int(Verdict::undecided)] ? 2 : 0;
}

int run_on_ranks(const RunOptions& options)
{
    RankOptions ranks = options.ranks;
    ranks.continuous = options.continuous;
    for (const auto& [name, given] : {std::pair{"--pairs", !options.outputs.pairs.empty()},
                                      {"--view", !options.view.empty()},
                                      {"--from-frame", options.from_frame != 0},
                                      {"--exit-code", options.exit_code}})
        if (given) ranks.not_for_ranks = name;
    return play_on_ranks(options.scene, options.settings, options.outputs, ranks);
}

int run(const RunOptions& options)
{
    const Shard shard = shard_from(options.shard);
    if (!shard.whole() && wants_ranks(options.ranks))
        usage("--shard is for independent processes: not under mpirun, and without checkpoints");
    if (wants_ranks(options.ranks)) return run_on_ranks(options);
    if (!shard.whole() && options.from_frame)
        usage("--shard and --from-frame: each selects the frames to run; give only one of them");
    const Settings settings = with_tried_backend(settings_from(options.settings));
    check_range("--from-frame", options.from_frame, 0);
    const bool from_file = is_scene_file(options.scene.scene);
    if (options.outputs.pairs == "-") usage("--pairs -: needs a file, because it is written in place");
    check_outputs(options.outputs, from_file ? options.scene.scene : "");
    check_view("--view", options.view, options.view_limit, options.outputs, {from_file ? options.scene.scene : ""});
    show_reading(options.outputs.quiet);
    Scene scene = open_scene(options.scene);
    if (!options.outputs.quiet) print_warnings(scene);
    if (const std::string why = why_nothing_is_compared(scene); !why.empty()) {
        const std::string said = fmt::format("{}: {}, so nothing is compared", options.scene.scene, why);
        if (options.exit_code) throw Error(ErrorKind::bad_data, said);
        if (!options.outputs.quiet) log(LogLevel::warning, said);
    }

    if (options.from_frame >= scene.frames)
        usage(fmt::format("--from-frame {}: the scene has frames 0 to {}", options.from_frame, scene.frames - 1));
    const auto [begin, end] = shard.range(std::size_t(scene.frames));
    const int first = shard.whole() ? options.from_frame : int(begin);
    if (options.continuous) check_rigid(scene.geometries);
    // The bodies start from the poses of the frame before.
    if (options.continuous) Mover().move(scene, std::max(first - 1, 0));
    Pipeline pipeline(scene, settings);
    pipeline.set_continuous(options.continuous);
    if (options.continuous && lists_pairs(options)) WorldAccess::parts_by_poses(pipeline.world());
    if (first) WorldAccess::continue_from(pipeline.world(), std::uint32_t(first), 0);
    std::optional<PairsFile> pairs;
    if (!options.outputs.pairs.empty())
        pairs.emplace(options.outputs.pairs, options.scene, scene, pipeline, first, options.outputs.separate);
    Report report(scene, pipeline, parts_of(options.outputs));
    const std::unique_ptr<ViewPage> page = view_page(options, scene, pipeline, int(end) - first);
    std::vector<FrameSink*> sinks;
    if (pairs) sinks.push_back(&*pairs);
    if (page) sinks.push_back(page.get());
    const int code = play(scene, pipeline, report, int(end), options.outputs, first, sinks);
    // If frames are missing, the line that marks a part is left out: such a file must not be merged.
    write_outputs(report, options.outputs,
                  code ? ""
                       : shard.line(fmt::format("run {}, {} bodies, {} frames, pace {}, settings {:016x}{}",
                                                printable(scene.name), scene.size(), scene.frames, scene.pace,
                                                hash_of(settings), options.outputs.separate ? ", separate" : "")));
    for (FrameSink* sink : sinks) sink->close();
    if (page && !options.outputs.quiet) log(LogLevel::note, page->summary());
    return code == 0 && options.exit_code ? code_of(report) : code;
}

} // namespace

void add_run(Arguments app)
{
    Arguments sub = app.add_command("run", "Run a scene file, or a scene of the catalogue, frame by frame");
    auto options = std::make_shared<RunOptions>();
    options->scene.on_demand = true;
    sub.add_option("scene SCENE.json|ASSEMBLY|NAME", options->scene.scene,
                   "scene file, glTF, COLLADA or 3MF assembly (each node that shows a mesh is a body), or a name from "
                   "'oncollide scene --list'")
        .required();
    add_catalogue_options(sub, options->scene), add_pace_option(sub, options->scene);
    add_cache_options(sub, options->scene.cache);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    add_output_options(sub, options->outputs);
    sub.group("Results");
    sub.add_flag("--exit-code", options->exit_code,
                 "exit with 1 if a pair collides in any frame, else with 2 if a pair is within or undecided (default: "
                 "0 for every run that succeeds)");
    sub.add_flag("--continuous", options->continuous,
                 "also find contacts on the way from frame to frame: each body moves in a straight line, and rotates "
                 "along the shorter arc, from each key of its motion to the next; meshes that deform are refused");
    const Option view = sub.add_option(
        "--view FILE.html", options->view,
        "write one HTML page that shows the run in 3D, frame by frame; needs three.js (Debian: libjs-three)");
    add_view_limit(sub, options->view_limit).needs(view);
    sub.add_option(
        "--pairs FILE.h5", options->outputs.pairs,
        "write the pairs of each frame as it is done (HDF5); if the run is cut off, the complete frames stay readable");
    sub.add_option("--from-frame N", options->from_frame,
                   "start at this frame; if --pairs names a file of the same run, append to it (default 0)");
    add_rank_options(sub, options->ranks);
    sub.add_option("--shard I/N", options->shard, std::string("divide the frames among N processes: ") + shard_help);
    sub.footer("Examples:\n"
               "  oncollide run factory.glb --exact on --exit-code\n"
               "  oncollide run city --frames 100\n"
               "  oncollide run town.json --max-error 0.01 --exact on --json results.json\n"
               "  oncollide run city --exact on --view city.html\n"
               "  oncollide run city --bodies 500 --skip exact --threads 0 --csv pairs.csv --trace trace.json\n"
               "  mpirun -n 8 oncollide run city --bodies 100000 --csv pairs.csv\n"
               "At the end the first colliding pairs are listed; --csv FILE or --json FILE write all of them.\n"
               "Formats of the results: docs/results.md, docs/view.md. mpirun needs a build with\n"
               "ONCOLLIDE_MPI: docs/many-processes.md.\n"
               "Ctrl-C stops after the current frame, or during it if that takes over half a second; the results so "
               "far are written, and the exit code is 130.");
    sub.action([options] { return run(*options); });
}

} // namespace oncollide::tools
