#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/play.hpp"
#include "cli/play_ranks.hpp"
#include "cli/shard.hpp"

#include <memory>

#include <fmt/format.h>

#include <oncollide/base/printable.hpp>
#include <oncollide/pipeline/result_hash.hpp>

namespace oncollide::tools {
namespace {

struct RunOptions {
    SceneOptions scene;
    SettingsOptions settings;
    OutputOptions outputs;
    RankOptions ranks;
    std::string shard;
};

int run(const RunOptions& options)
{
    const Shard shard = shard_from(options.shard);
    if (!shard.whole() && wants_ranks(options.ranks))
        usage("--shard is for processes that know nothing of each other: not under mpirun, without checkpoints");
    if (wants_ranks(options.ranks))
        return play_on_ranks(options.scene, options.settings, options.outputs, options.ranks);
    const Settings settings = settings_from(options.settings);
    const bool from_file = is_scene_file(options.scene.scene);
    check_outputs(options.outputs, from_file ? options.scene.scene : "");
    Scene scene = open_scene(options.scene);
    if (!options.outputs.quiet) print_warnings(scene);

    Pipeline pipeline(scene, settings);
    Report report(scene, pipeline, parts_of(options.outputs));
    const auto [first, end] = shard.range(std::size_t(scene.frames));
    const int code = play(scene, pipeline, report, int(end), options.outputs, int(first));
    // Without the mark of a part where frames are missing: it must not be merged.
    write_outputs(report, options.outputs,
                  code ? ""
                       : shard.line(fmt::format("run {}, {} bodies, {} frames, pace {}, settings {:016x}{}",
                                                printable(scene.name), scene.size(), scene.frames, scene.pace,
                                                hash_of(settings), options.outputs.separate ? ", separate" : "")));
    return code;
}

} // namespace

void add_run(Arguments app)
{
    Arguments sub = app.add_command("run", "Run a scene frame by frame: a scene file, or a scene of the catalogue");
    auto options = std::make_shared<RunOptions>();
    sub.add_option("scene", options->scene.scene,
                   "scene file, glTF assembly (each node that shows a mesh is a body), or a name from "
                   "'oncollide scene --list'")
        .required()
        .type_name("SCENE.json|ASSEMBLY.glb|NAME");
    add_catalogue_options(sub, options->scene), add_pace_option(sub, options->scene);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    add_output_options(sub, options->outputs);
    add_rank_options(sub, options->ranks);
    sub.add_option("--shard", options->shard, std::string("of the frames, ") + shard_help).type_name("I/N");
    sub.footer("Examples:\n"
               "  oncollide run city --frames 100\n"
               "  oncollide run town.json --max-error 0.01 --exact fcl --json results.json\n"
               "  oncollide run city --bodies 500 --skip exact --threads 0 --csv pairs.csv --trace trace.json\n"
               "Stages: bounds, delimitation, broad, ocst, exact. Formats of the results: docs/results.md.\n"
               "  mpirun -n 8 oncollide run city --bodies 100000 --csv pairs.csv\n"
               "The last needs a build with ONCOLLIDE_MPI: docs/many-processes.md.\n"
               "Ctrl-C stops after the frame in hand, or in it if that takes over half a second; what was computed is "
               "written, and the exit code is 130.");
    sub.action([options] { return run(*options); });
}

} // namespace oncollide::tools
