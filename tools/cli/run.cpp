#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/play.hpp"

#include <memory>

namespace oncollide::tools {
namespace {

struct RunOptions {
    SceneOptions scene;
    SettingsOptions settings;
    OutputOptions outputs;
};

int run(const RunOptions& options)
{
    const Settings settings = settings_from(options.settings);
    const bool from_file = is_scene_file(options.scene.scene);
    check_outputs(options.outputs, from_file ? options.scene.scene : "");
    Scene scene = open_scene(options.scene);
    if (!options.outputs.quiet) print_warnings(scene);

    Pipeline pipeline(scene, settings);
    Report report(scene, pipeline, parts_of(options.outputs));
    const int code = play(scene, pipeline, report, scene.frames, options.outputs);
    write_outputs(report, options.outputs);
    return code;
}

} // namespace

void add_run(Arguments app)
{
    Arguments sub = app.add_command("run", "Run a scene frame by frame: a scene file, or a scene of the catalogue");
    auto options = std::make_shared<RunOptions>();
    options->scene.on_demand = true;
    sub.add_option("scene", options->scene.scene,
                   "scene file, glTF assembly (each node that shows a mesh is a body), or a name from "
                   "'oncollide scene --list'")
        .required()
        .type_name("SCENE.json|ASSEMBLY.glb|NAME");
    add_catalogue_options(sub, options->scene), add_pace_option(sub, options->scene);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    add_cache_options(sub, options->scene.cache);
    add_output_options(sub, options->outputs);
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
