#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/pairs_file.hpp"

#include <memory>
#include <optional>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

struct RunOptions {
    SceneOptions scene;
    SettingsOptions settings;
    OutputOptions outputs;
    int from_frame = 0;
};

int run(const RunOptions& options)
{
    const Settings settings = settings_from(options.settings);
    check_range("--from-frame", options.from_frame, 0);
    const bool from_file = is_scene_file(options.scene.scene);
    if (options.outputs.pairs == "-") usage("--pairs -: is written in place, so it must be a file");
    check_outputs(options.outputs, from_file ? options.scene.scene : "");
    Scene scene = open_scene(options.scene);
    if (!options.outputs.quiet) print_warnings(scene);

    const int first = options.from_frame;
    if (first >= scene.frames)
        usage(fmt::format("--from-frame {}: the scene has frames 0 to {}", first, scene.frames - 1));
    Pipeline pipeline(scene, settings);
    if (first) pipeline.world().continue_from(std::uint32_t(first), 0);
    std::optional<PairsFile> pairs;
    if (!options.outputs.pairs.empty())
        pairs.emplace(options.outputs.pairs, scene, pipeline, first, options.outputs.separate);
    Report report(scene, pipeline, parts_of(options.outputs));
    const int code = play(scene, pipeline, report, scene.frames, options.outputs, first, pairs ? &*pairs : nullptr);
    write_outputs(report, options.outputs);
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
    sub.add_option("--pairs", options->outputs.pairs,
                   "write the pairs of each frame as it is done (HDF5); readable up to the last whole frame, whatever "
                   "ends the run")
        .type_name("FILE.h5");
    sub.add_option("--from-frame", options->from_frame,
                   "begin with this frame; where --pairs names a file of the same run, go on with that (default 0)")
        .type_name("N");
    sub.footer("Examples:\n"
               "  oncollide run city --frames 100\n"
               "  oncollide run town.json --max-error 0.01 --exact fcl --json results.json\n"
               "  oncollide run city --bodies 500 --skip exact --threads 0 --csv pairs.csv --trace trace.json\n"
               "Stages: bounds, delimitation, broad, ocst, exact. Formats of the results: docs/results.md.\n"
               "Ctrl-C stops after the frame in hand, or in it if that takes over half a second; what was computed is "
               "written, and the exit code is 130.");
    sub.action([options] { return run(*options); });
}

} // namespace oncollide::tools
