#include "cli/command.hpp"
#include "cli/standard_output.hpp"
#include "render/backend_trial.hpp"
#include "render/painter_process.hpp"
#include "render/png.hpp"
#include "render/ray_picture.hpp"
#include "render/render_plan.hpp"
#include "trees/grown_tree.hpp"

#include <algorithm>
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
    std::size_t spheres = 0, red = 0, meeting = 0; ///< counts of all panels
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
Image draw(PainterProcess& painter, std::vector<ScenePicture>& panels, const Camera& camera, const RenderPlan& plan)
{
    Image image = blank(plan.width, plan.height);
    for (std::size_t k = 0; k < panels.size(); ++k) {
        panels[k].camera = camera;
        paste(painter.draw(panels[k]), panels[k].width, image, int(k) * panels[k].width);
    }
    return image;
}

bool shows_red(const Image& image)
{
    for (std::size_t at = 0; at < image.pixels.size(); at += 3)
        if (const std::uint8_t* p = &image.pixels[at]; p[0] > 2 * p[1] && p[0] > 2 * p[2]) return true;
    return false;
}

/// Draws all images by casts. No stage plays, so no trees age and no frame depends on earlier frames.
void render_rays(Scene& scene, const RenderOptions& options, const Settings& settings, const RenderPlan& plan,
                 const View& view)
{
    RayPictures pictures(scene, settings, shown_from(options, settings, scene).bodies);
    Mover mover;
    const int width = plan.width / plan.panels();
    Framing framing(width, plan.height);
    const auto each_frame = [&](const ImagePlan& image, auto take) {
        for (std::size_t k = 0; k < image.frames.size(); ++k)
            mover.move(scene, image.frames[k]), pictures.move(scene), take(int(k));
    };
    if (view.automatic())
        for (const ImagePlan& image : plan.images) each_frame(image, [&](int) { pictures.frame(framing); });
    for (const ImagePlan& image : plan.images) {
        Image drawn = blank(plan.width, plan.height);
        each_frame(image, [&](int k) {
            paste(pictures.draw(view.camera(framing), width, plan.height).pixels, width, drawn, k * width);
        });
        save_png(drawn, image.file);
    }
    if (!options.quiet)
        write_to_stdout(fmt::format("{}: {} rays, {} hits, {:.2f} microseconds per ray on {} threads\n",
                                    printable(options.out), pictures.rays(), pictures.hits(),
                                    1e3 * pictures.milliseconds() / double(pictures.rays()), thread_count(settings)),
                        options.out == "-");
}

int render(const RenderOptions& options)
{
    Settings settings = with_tried_backend(settings_from(options.settings));
    if (!settings.depth && !settings.max_error && !options.rays) settings.depth = 6; // the sphere-trees are drawn
    const View view(options);
    PainterProcess painter(settings.gpu);
    SceneOptions source = options.scene;
    source.on_demand = options.rays;
    Scene scene = open_scene(source);
    const RenderPlan plan = plan_from(options, settings, scene);
    shown_from(options, settings, scene);
    const std::string input = is_scene_file(options.scene.scene) ? options.scene.scene : "";
    for (const ImagePlan& image : plan.images) check_files({{"--out", image.file}}, {input});
    check_extension("--out", options.out, {".png"});
    if (!options.quiet) print_warnings(scene);
    if (options.rays) {
        render_rays(scene, options, settings, plan, view);
        return 0;
    }
    painter.open();

    // All images share one camera, whose position is known only after all pictures were seen.
    Framing framing(plan.width / plan.panels(), plan.height);
    const auto see = [&](const Panels& panels) {
        for (const Picture& picture : panels.pictures) framing.add(picture);
    };
    const bool twice = view.automatic() && plan.images.size() > 1;
    if (twice) play(scene, options, settings, plan, [&](const ImagePlan&, const Panels& panels) { see(panels); });
    play(scene, options, settings, plan, [&](const ImagePlan& image, Panels& panels) {
        if (!twice) see(panels);
        const Image drawn = draw(painter, panels.pictures, view.camera(framing), plan);
        save_png(drawn, image.file);
        if (!options.quiet)
            write_to_stdout(fmt::format("{}: {} spheres, {} of them red{}{}\n", printable(image.file), panels.spheres,
                                        panels.red,
                                        panels.meeting ? fmt::format("; {} triangles that meet", panels.meeting) : "",
                                        (panels.red || panels.meeting) && !shows_red(drawn)
                                            ? "; all of the red is hidden: try --show spheres, --body or --eye"
                                            : ""),
                            image.file == "-");
    });
    return 0;
}

void add_drawing_options(Arguments command, RenderOptions& o)
{
    command
        .add_option("--frame N[,N...]", o.frames, "frame to draw (default: the last); 10,20,30: several, side by side")
        .separated_by(',');
    command.add_option("--every K", o.every, "draw every K-th frame up to --frame: FILE-0000.png, FILE-0010.png, ...");
    command.add_option("--out FILE", o.out, "file to write (PNG); '-' is standard output").required();
    command.add_option("--size WxH", o.size, "pixels (default 1280x720)");
    command.add_option("--show WHAT", o.show, "meshes, spheres or both (default both)");
    command.add_option("--level L[,L...]", o.levels, "draw only spheres of this level; 2,4,6: several, side by side")
        .separated_by(',');
    command.add_flag("--rays", o.rays,
                     "cast four rays per pixel instead of drawing triangles: needs no OpenGL, reads cooked files on "
                     "demand; surfaces only");
    command.add_flag("--whole", o.whole, "grow whole trees, not only where bodies meet; needs --level");
    command.add_option("--body NAME", o.bodies, "draw only this body (repeatable)").repeatable();
    command.add_option("--eye \"x y z\"", o.eye, "camera position (default: such that all bodies are visible)");
    command.add_option("--look-at \"x y z\"", o.look_at, "point to look at (default: the centre)");
    command.add_flag("--quiet", o.quiet, "print only errors");
}

} // namespace

void add_render(Arguments app)
{
    Arguments sub = app.add_command("render", "Draw a scene and its sphere-trees as PNG; needs no display");
    auto options = std::make_shared<RenderOptions>();
    sub.add_option("scene SCENE.json|NAME", options->scene.scene, "scene file, or a name from 'oncollide scene --list'")
        .required();
    add_drawing_options(sub, *options);
    add_catalogue_options(sub, options->scene);
    add_accuracy_options(sub, options->settings);
    add_pipeline_options(sub, options->settings);
    sub.footer("Examples:\n"
               "  oncollide render paper --frame 1100 --exact on --out contact.png\n"
               "  oncollide render paper --body dragon --whole --show spheres --level 2,4,6 --out levels.png\n"
               "  oncollide render city --bodies 300 --every 10 --frame 100 --out city.png\n"
               "  oncollide render hills --rays --threads 0 --out hills.png\n"
               "Spheres are drawn at the finest level that the trees hold in that frame; red spheres touch "
               "spheres of\n"
               "another body from which this body was not certified separate. With --exact on, intersecting triangles "
               "of\n"
               "colliding meshes are red. More: docs/pictures.md.");
    sub.action([options] { return render(*options); });
}

} // namespace oncollide::tools
