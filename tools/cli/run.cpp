#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/play.hpp"

#include <iostream>
#include <memory>

#include "view/view_page.hpp"

#include <oncollide/base/parallel.hpp>

namespace oncollide::tools {
namespace {

struct RunOptions {
    SceneOptions scene;
    SettingsOptions settings;
    OutputOptions outputs;
    std::string view;
    int view_limit = 40; ///< MB
};

/// The page of --view; null: none was requested.
std::unique_ptr<ViewPage> view_page(const RunOptions& options, const Scene& scene, const Pipeline& pipeline)
{
    if (options.view.empty()) return nullptr;
    return std::make_unique<ViewPage>(scene, pipeline,
                                      ViewPage::Options{.file = options.view,
                                                        .most_bytes = std::size_t(options.view_limit) * 1'000'000,
                                                        .separate = options.outputs.separate,
                                                        .threads = thread_count(pipeline.settings())});
}

int run(const RunOptions& options)
{
    const Settings settings = settings_from(options.settings);
    const bool from_file = is_scene_file(options.scene.scene);
    check_outputs(options.outputs, from_file ? options.scene.scene : "");
    check_view(options.view, options.view_limit, options.outputs, from_file ? options.scene.scene : "");
    Scene scene = open_scene(options.scene);
    if (!options.outputs.quiet) print_warnings(scene);

    Pipeline pipeline(scene, settings);
    Report report(scene, pipeline, parts_of(options.outputs));
    const std::unique_ptr<ViewPage> page = view_page(options, scene, pipeline);
    const int code = play(scene, pipeline, report, scene.frames, options.outputs, page.get());
    write_outputs(report, options.outputs);
    if (page) page->write();
    if (page && !options.outputs.quiet) std::cerr << page->summary() << "\n";
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
    const Option view =
        sub.add_option("--view", options->view,
                       "write one HTML page that shows the run in 3D, frame by frame; needs Debian's libjs-three")
            .type_name("FILE.html")
            .check([](const std::string& file) { return std::string(file.empty() ? "the file name is empty" : ""); });
    sub.add_option("--view-limit", options->view_limit,
                   "size of that page in MB (default 40): frames and meshes beyond are thinned out, which it says")
        .type_name("MB")
        .needs(view);
    sub.footer(
        "Examples:\n"
        "  oncollide run city --frames 100\n"
        "  oncollide run town.json --max-error 0.01 --exact fcl --json results.json\n"
        "  oncollide run city --exact predicates --view city.html\n"
        "  oncollide run city --bodies 500 --skip exact --threads 0 --csv pairs.csv --trace trace.json\n"
        "Stages: bounds, delimitation, broad, ocst, exact. Formats of the results: docs/results.md, docs/view.md.\n"
        "Ctrl-C stops after the frame in hand, or in it if that takes over half a second; what was computed is "
        "written, and the exit code is 130.");
    sub.action([options] { return run(*options); });
}

} // namespace oncollide::tools
