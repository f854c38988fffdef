#include "cli/command.hpp"
#include "render/png.hpp"
#include "render/render_plan.hpp"
#include "verify/trees/grown_tree.hpp"

#include <algorithm>
#include <iostream>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide::tools {
namespace {

/// The contents of an image: its panels from left to right.
struct Panels {
    std::vector<ScenePicture> pictures;
    std::size_t spheres = 0, red = 0, meeting = 0; ///< of all panels
};

/// Plays the scene from its start, so that trees grow and age as in a run, and passes on each image's panels.
template <class Take>
void play(Scene& scene, const RenderOptions& options, const Settings& settings, const RenderPlan& plan, Take take)
{
    ScenePictures pictures(scene, shown_from(options, settings, scene));
    Pipeline pipeline(scene, settings);
    GrownTrees whole(scene, plan.deepest, thread_count(settings));
    const TreeOf tree_of = [&](GeometryId id) -> const Ocst* {
        if (!has_spheres(scene.geometries[index(id)].data)) return nullptr;
        return options.whole ? &whole[id].tree() : WorldAccess::tree(pipeline.world(), pipeline.model(id));
    };
    Mover mover;
    int next = 0;
    for (const ImagePlan& image : plan.images) {
        Panels panels;
        for (int frame : image.frames) {
            if (options.whole) next = frame; // whole trees do not depend on earlier frames
            std::span<const PairResult> pairs;
            for (; next <= frame; ++next) {
                mover.move(scene, next);
                pairs = pipeline.step(scene).pairs;
            }
            for (std::optional<int> level : plan.levels) {
                ScenePicture picture = pictures.make(pipeline.world(), tree_of, pairs, level);
                picture.width = plan.width / plan.panels(), picture.height = plan.height;
                panels.pictures.push_back(std::move(picture));
                panels.spheres += pictures.spheres(), panels.red += pictures.red();
                panels.meeting += pictures.meeting();
            }
        }
        take(image, panels);
    }
}

/// Draws panels side by side. Columns that no panel covers are background.
Image draw(Painter& painter, std::vector<ScenePicture>& panels, const Camera& camera, const RenderPlan& plan)
{
    Image image{plan.width, plan.height, std::vector<std::uint8_t>(3 * std::size_t(plan.width * plan.height), 255)};
    for (std::size_t k = 0; k < panels.size(); ++k) {
        panels[k].camera = camera;
        const std::vector<std::uint8_t> pixels = painter.draw(panels[k]);
        const auto row = std::ptrdiff_t(3 * panels[k].width);
        for (int y = 0; y < plan.height; ++y)
            std::copy_n(pixels.begin() + row * y, row, image.pixels.begin() + 3 * plan.width * y + row * int(k));
    }
    return image;
}

int render(const RenderOptions& options)
{
    Settings settings = settings_from(options.settings);
    if (!settings.depth && !settings.max_error) settings.depth = 6; // the sphere-trees are drawn
    const View view(options);
    Scene scene = open_scene(options.scene);
    const RenderPlan plan = plan_from(options, settings, scene);
    shown_from(options, settings, scene);
    const std::string input = is_scene_file(options.scene.scene) ? options.scene.scene : "";
    for (const ImagePlan& image : plan.images) check_files({{"--out", image.file}}, {input});
    check_extension("--out", options.out, {".png"});
    if (!options.quiet) print_warnings(scene);
    Painter painter(settings.gpu);

    // All images share a camera, whose position is known only after all pictures were seen.
    Framing framing;
    const auto see = [&](const Panels& panels) {
        for (const Picture& picture : panels.pictures) framing.add(picture);
    };
    const bool twice = view.automatic() && plan.images.size() > 1;
    if (twice) play(scene, options, settings, plan, [&](const ImagePlan&, const Panels& panels) { see(panels); });
    play(scene, options, settings, plan, [&](const ImagePlan& image, Panels& panels) {
        if (!twice) see(panels);
        save_png(draw(painter, panels.pictures, view.camera(framing), plan), image.file);
        if (!options.quiet)
            (image.file == "-" ? std::cerr : std::cout)
                << fmt::format("{}: {} spheres, {} of them red{}\n", printable(image.file), panels.spheres, panels.red,
                               panels.meeting ? fmt::format("; {} triangles that meet", panels.meeting) : "");
    });
    return 0;
}

void add_drawing_options(Arguments command, RenderOptions& o)
{
    command.add_option("--frame", o.frames, "frame to draw (default: the last); 10,20,30: several, side by side")
        .type_name("N[,N...]")
        .separated_by(',');
    command.add_option("--every", o.every, "draw every K-th frame up to --frame: FILE-0000.png, FILE-0010.png, ...")
        .type_name("K");
    command.add_option("--out", o.out, "file to write (PNG); '-' is standard output").type_name("FILE").required();
    command.add_option("--size", o.size, "pixels (default 1280x720)").type_name("WxH");
    command.add_option("--show", o.show, "meshes, spheres or both (default both)").type_name("WHAT");
    command.add_option("--level", o.levels, "draw only spheres of this level; 2,4,6: several, side by side")
        .type_name("L[,L...]")
        .separated_by(',');
    command.add_flag("--whole", o.whole, "grow whole trees, not only where bodies meet; needs --level");
    command.add_option("--body", o.bodies, "draw only this body (repeatable)").type_name("NAME").repeatable();
    command.add_option("--eye", o.eye, "camera position (default: such that all bodies are visible)")
        .type_name("\"x y z\"");
    command.add_option("--look-at", o.look_at, "point to look at (default: the centre)").type_name("\"x y z\"");
    command.add_flag("--quiet", o.quiet, "print only errors");
}

} // namespace

void add_render(Arguments app)
{
    Arguments sub = app.add_command("render", "Draw a scene and its sphere-trees as PNG; needs no display");
    auto options = std::make_shared<RenderOptions>();
    sub.add_option("scene", options->scene.scene, "scene file, or a name from 'oncollide scene --list'")
        .required()
        .type_name("SCENE.json|NAME");
    add_drawing_options(sub, *options);
    add_catalogue_options(sub, options->scene);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    sub.footer("Examples:\n"
               "  oncollide render paper --frame 1200 --out contact.png\n"
               "  oncollide render paper --body dragon --whole --show spheres --level 2,4,6 --out levels.png\n"
               "  oncollide render city --bodies 300 --every 10 --frame 100 --out city.png\n"
               "Spheres are drawn at the finest level that the trees hold in that frame; red spheres touch "
               "spheres of\n"
               "another body from which this body was not certified separate. With --exact on, intersecting triangles "
               "of\n"
               "colliding meshes are red. More: docs/pictures.md.");
    sub.action([options] { return render(*options); });
}

} // namespace oncollide::tools
