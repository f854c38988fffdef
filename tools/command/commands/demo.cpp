#include "cli/command.hpp"
#include "cli/outputs.hpp"
#include "cli/standard_output.hpp"
#include "play/play.hpp"
#include "render/flat_picture.hpp"
#include "render/framing.hpp"
#include "render/render_scene.hpp"
#include "view/view_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

constexpr std::uint64_t seed = 2006;
constexpr int frames = 60;
constexpr int halls = 16, pillars = 4, parts_of_hall = 24;
constexpr double hall = 3.5, half_plain = 150; // half-extents, metres

/// The k-th vector of body `index`; coordinates are uniform in [-1, 1).
Eigen::Vector3d random_vector(std::uint64_t index, std::uint64_t k)
{
    Eigen::Vector3d v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = 2 * u01(seed, index, 3 * k + std::uint64_t(axis)) - 1;
    return v;
}

Eigen::Isometry3d random_pose(const Eigen::Vector3d& position, std::uint64_t index)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const Eigen::Vector3d axis = random_vector(index, 7) + Eigen::Vector3d(0, 0, 1e-3);
    pose.linear() = Eigen::AngleAxisd(std::numbers::pi * u01(seed, index, 40), axis.normalized()).toRotationMatrix();
    pose.translation() = position;
    return pose;
}

/// Four pillars around `centre`, and between them machine parts that tumble and bounce off the walls.
void add_hall(Scene& scene, int number, const Eigen::Vector3d& centre, GeometryId pillar,
              const std::vector<GeometryId>& parts, std::uint64_t& index)
{
    const Aabb walls{centre.array() - hall, centre.array() + hall};
    for (int corner = 0; corner < pillars; ++corner) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = centre + Eigen::Vector3d(corner & 1 ? hall : -hall, corner & 2 ? hall : -hall, 0);
        scene.add_body(
            {.name = fmt::format("pillar {}.{}", number, corner), .geometry = pillar, .pose = pose, .is_static = true});
    }
    for (int p = 0; p < parts_of_hall; ++p) {
        const GeometryId geometry = parts[std::size_t(p) % parts.size()];
        const std::string& kind = scene.geometries[oncollide::index(geometry)].name;
        const Eigen::Vector3d position = centre + hall * random_vector(++index, 1);
        scene.add_body({.name = fmt::format("{} {}.{}", kind, number, p),
                        .geometry = geometry,
                        .pose = random_pose(position, index),
                        .motion = Drift{0.06 * random_vector(index, 2), 0.05 * random_vector(index, 3), walls}});
    }
}

/// Halls with tumbling machine parts on a wide plain of masts, with drones flying between them. The scene gives every
/// level work: regions that hold only static masts, overlapping AABBs, sphere-trees to grow, triangles to test.
Scene make_demo_scene()
{
    constexpr int masts = 1500, drones = 40;
    Scene scene;
    scene.name = "demo";
    scene.frames = frames;
    const std::vector<GeometryId> parts{
        scene.add("gear", make_gear_mesh(16, 0.8, 1.0, 0.35, 0.3)),
        scene.add("knot", make_torus_knot_mesh(2, 3, 0.6, 0.25, 0.12, 3000)),
        scene.add("ring", make_torus_mesh(0.8, 0.2, 1600)),
        scene.add("ball", make_sphere_mesh(0.5, 800)),
        scene.add("rod", Capsule{.radius = 0.15, .length = 1.6}),
    };
    const GeometryId pillar = scene.add("pillar", Box{{0.4, 0.4, hall}});
    const GeometryId mast = scene.add("mast", Cylinder{.radius = 0.3, .length = 2 * hall});
    const GeometryId drone = scene.add("drone", make_torus_mesh(0.7, 0.15, 1000));

    std::uint64_t index = 0;
    const Aabb plain{{-half_plain, -half_plain, 0}, {half_plain, half_plain, 2 * hall}};
    const auto somewhere = [&] {
        return Eigen::Vector3d(plain.centre() + plain.half_extent().cwiseProduct(random_vector(++index, 0)));
    };
    for (int h = 0; h < halls; ++h) {
        Eigen::Vector3d centre = somewhere();
        centre.z() = hall;
        add_hall(scene, h, centre, pillar, parts, index);
    }
    for (int k = 0; k < masts; ++k) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = somewhere();
        pose.translation().z() = hall;
        scene.add_body({.name = fmt::format("mast {}", k), .geometry = mast, .pose = pose, .is_static = true});
    }
    for (int k = 0; k < drones; ++k) {
        const Eigen::Vector3d position = somewhere();
        scene.add_body({.name = fmt::format("drone {}", k),
                        .geometry = drone,
                        .pose = random_pose(position, index),
                        .motion = Drift{random_vector(index, 2), 0.1 * random_vector(index, 3), plain}});
    }
    return scene;
}

/// Keeps the pairs of the last frame.
struct LastPairs final : FrameSink {
    std::vector<PairResult> pairs;
    void add(const FrameView& frame) override { pairs.assign(frame.pairs.begin(), frame.pairs.end()); }
    void close() override {}
};

/// Draws the hall in which most meshes collide, without the parts that collide with none; triangles that meet are red.
void draw_hall(const Scene& scene, const World& world, std::span<const PairResult> pairs,
               const std::filesystem::path& file)
{
    constexpr std::uint32_t bodies_of_hall = pillars + parts_of_hall; // the halls are the first bodies
    const auto is_mesh = [&](BodyId body) {
        return std::holds_alternative<Mesh>(scene.geometries[index(scene.geometry[index(body)])].data);
    };
    std::array<std::vector<std::uint32_t>, halls> colliding;
    for (const PairResult& pair : pairs) {
        const std::uint32_t number = index(pair.a) / bodies_of_hall;
        if (pair.verdict == Verdict::colliding && number < halls && index(pair.b) / bodies_of_hall == number &&
            is_mesh(pair.a) && is_mesh(pair.b))
            colliding[number].insert(colliding[number].end(), {index(pair.a), index(pair.b)});
    }
    ScenePictures::Shown shown{
        .meshes = true, .spheres = false, .bodies = std::vector<std::uint8_t>(scene.size()), .meeting = true};
    for (const std::uint32_t body : *std::ranges::max_element(colliding, {}, &std::vector<std::uint32_t>::size))
        shown.bodies[body] = 1;
    ScenePictures pictures(scene, std::move(shown));
    ScenePicture picture = pictures.make(world, {}, pairs, std::nullopt);
    picture.width = 960, picture.height = 640;
    Framing framing(picture.width, picture.height);
    framing.add(picture);
    picture.camera = framing.camera();
    save_png(draw_bodies(picture), file);
}

struct DemoOptions {
    std::string out = "demo-results";
};

int demo(const DemoOptions& options)
{
    namespace fs = std::filesystem;
    const fs::path folder = options.out;
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw Error(ErrorKind::cannot_write,
                    fmt::format("{}: cannot make the folder: {}", folder.string(), error.message()));
    OutputOptions outputs;
    outputs.json = (folder / "results.json").string();
    outputs.csv = (folder / "results.csv").string();
    outputs.trace = (folder / "trace.json").string();
    outputs.picture = (folder / "picture.svg").string();
    check_outputs(outputs, "");
    const std::string page_file = (folder / "page.html").string(), collision = (folder / "collision.png").string();
    check_files({{"--out", page_file}, {"--out", collision}});

    Scene scene = make_demo_scene();
    Settings settings;
    settings.depth = 6;
    settings.exact = ExactLevel::predicates;
    settings.bounding_volume = BoundingVolume::sphere; // as in the paper
    settings.threads = 0;
    write_to_stdout(fmt::format(
        "Machine parts tumble in halls on a plain of masts, and drones fly between the masts: {} bodies, {} "
        "geometries, {} frames.\n"
        "Four levels find the pairs that collide. Each level works on the pairs that the level before left over.\n\n",
        scene.size(), scene.geometries.size(), frames));
    flush_stdout();
    Pipeline pipeline(scene, settings);
    Report report(scene, pipeline, parts_of(outputs));
    LastPairs last;
    std::vector<FrameSink*> sinks{&last};
    std::optional<ViewPage> page;
    std::string page_line = "the run in 3D, frame by frame, for a browser";
    try {
        page.emplace(scene, pipeline, ViewPage::Options{.file = page_file, .threads = settings.threads});
        sinks.push_back(&*page);
    } catch (const Error& without_three_js) {
        if (without_three_js.kind() != ErrorKind::no_input) throw;
        page_line = fmt::format("not written: {}", without_three_js.what());
    }
    const int code = play(scene, pipeline, report, frames, outputs, 0, sinks);
    if (page) page->close();
    write_outputs(report, outputs); // comes before the picture, whose memory may not suffice
    draw_hall(scene, pipeline.world(), last.pairs, collision);
    write_to_stdout(printable_lines(fmt::format("\nWritten to {0}/:\n"
                                                "  page.html      {1}\n"
                                                "  collision.png  parts that collide in the last frame; triangles that "
                                                "meet are red\n"
                                                "  picture.svg    stages and times, for a browser\n"
                                                "  results.json   settings, counts and every pair of every frame\n"
                                                "  results.csv    the same pairs as a table\n"
                                                "  trace.json     for https://ui.perfetto.dev or chrome://tracing\n"
                                                "To open them: xdg-open {2}\n",
                                                folder.string(), page_line, page ? page_file : collision)));
    return code;
}

} // namespace

void add_demo(Arguments app)
{
    Arguments sub = app.add_command("demo", "Run a built-in scene and write its results, a 3D page and pictures");
    auto options = std::make_shared<DemoOptions>();
    sub.add_option("--out DIR", options->out, "folder for the results (default demo-results)");
    sub.footer("Needs no data, no display and no network.");
    sub.action([options] { return demo(*options); });
}

} // namespace oncollide::tools
