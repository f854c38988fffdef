#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/outputs.hpp"
#include "cli/standard_output.hpp"

#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide::tools {
namespace {

struct WriteOptions {
    SceneOptions scene;
    std::string out;
    bool list = false;
};

int list_scenes()
{
    std::size_t longest = 0;
    for (const CatalogueEntry& entry : catalogue()) longest = std::max(longest, entry.name.size());
    for (const CatalogueEntry& entry : catalogue())
        write_to_stdout(fmt::format("{:<{}}  {}\n", entry.name, longest, entry.summary));
    return 0;
}

int write_scene(const WriteOptions& options)
{
    if (options.list) return list_scenes();
    if (options.scene.scene.empty()) usage("scene: give a NAME, a FILE, or --list to list the names");
    if (options.out.empty() || options.out == "-")
        usage("scene: --out FILE.json is required; mesh files may be written into the same folder");
    check_files({{"--out", options.out}}, {is_scene_file(options.scene.scene) ? options.scene.scene : ""});
    const Scene scene = open_scene(options.scene);
    print_warnings(scene);
    save_scene(scene, options.out);
    write_to_stdout(fmt::format("{}: {} bodies, {} geometries, {} frames\n", printable(options.out), scene.size(),
                                scene.geometries.size(), scene.frames));
    return 0;
}

} // namespace

void add_scene(Arguments app)
{
    Arguments sub = app.add_command("scene", "List the catalogue of scenes, or write a scene as a scene file");
    auto options = std::make_shared<WriteOptions>();
    sub.add_option("name NAME|FILE", options->scene.scene,
                   "a scene of the catalogue, or a file: .glb, .gltf, .dae, .3mf, .json");
    sub.add_flag("--list", options->list, "list the scenes");
    sub.add_option("--out SCENE.json", options->out, "scene file to write");
    add_catalogue_options(sub, options->scene);
    sub.footer("Examples:\n"
               "  oncollide scene --list\n"
               "  oncollide scene city --bodies 200 --seed 7 --out city.json\n"
               "  oncollide run city.json\n"
               "  oncollide scene factory.glb --out factory.json\n"
               "The format of scene files: docs/scene-format.md.");
    sub.action([options] { return write_scene(*options); });
}

} // namespace oncollide::tools
