#include <oncollide/runs/pipeline.hpp>

#include <utility>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/runs/deforming_models.hpp>

namespace oncollide {

struct Pipeline::Played {
    std::vector<std::shared_ptr<const Geometry>> geometries;
    std::uint32_t bodies = 0;
    ChangeLog::Mark changes;  ///< the mark of the scene, already applied to the World
    std::size_t excluded = 0; ///< number of pairs applied
    double time = 0;          ///< time of the scene's motions, as of the last call
    std::uint32_t calls = 0;
    std::vector<std::uint32_t> moved; ///< by body: the last call that set its motion
};

Pipeline::Pipeline(const Scene& scene, World world) : world_(std::move(world)), played_(std::make_unique<Played>())
{
    if (world_.models().size() || world_.bodies().size())
        throw Error(ErrorKind::usage, "Pipeline: the World has models or bodies; pass a new World");
    play(scene);
}
Pipeline::Pipeline(const Scene& scene, const Settings& settings) : Pipeline(scene, World(settings)) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;

FrameView Pipeline::step(const Scene& scene)
{
    play(scene);
    return world_.step();
}

void Pipeline::play_geometries(const Scene& scene)
{
    auto& known = played_->geometries;
    if (continuous_) check_rigid(scene.geometries);
    if (scene.geometries.size() < known.size())
        throw Error(ErrorKind::usage,
                    fmt::format("the scene has {} geometries, {} in the last call; pass the same scene",
                                scene.geometries.size(), known.size()));
    for (std::uint32_t g = 0; g < scene.geometries.size(); ++g) {
        const std::shared_ptr<const Geometry>& geometry = scene.geometries.share(g);
        if (g == known.size())
            add_model(world_.models(), scene.geometries, g), known.push_back(geometry);
        else if (known[g] != geometry)
            renew_model(world_.models(), world_.models().at(g), scene.geometries, g), known[g] = geometry;
    }
}

void Pipeline::add_body(const Scene& scene, std::uint32_t body)
{
    world_.bodies().add({.model = model(scene.geometry[body]),
                         .pose = scene.poses[body],
                         .is_static = scene.is_static[body] != 0,
                         .layer = scene.layers[body],
                         .mask = scene.masks[body],
                         .group = scene.groups[body]});
}

void Pipeline::move_body(const Scene& scene, std::uint32_t body)
{
    const BodyId id = world_.bodies().at(body);
    const Eigen::Isometry3d pose = scene.poses[body];
    if (!continuous_) return world_.bodies().set_pose(id, pose);
    Played& p = *played_;
    if (p.moved.size() <= body) p.moved.resize(scene.size());
    if (std::exchange(p.moved[body], p.calls) == p.calls) return;
    const auto way = way_between(scene.motions[body], p.time, scene.time, world_.bodies().pose(id), pose);
    way.size() > 2 ? world_.bodies().set_motion(id, RigidMotion(way)) : world_.bodies().set_motion(id, pose);
}

/// The World ignores values that have not changed.
void Pipeline::change_body(const Scene& scene, std::uint32_t body)
{
    const BodyId id = world_.bodies().at(body);
    move_body(scene, body);
    if (const ModelId of = model(scene.geometry[body]); world_.bodies().model(id) != of)
        world_.bodies().set_model(id, of);
    world_.bodies().set_static(id, scene.is_static[body] != 0);
    world_.bodies().set_filter(id, {scene.layers[body], scene.masks[body], scene.groups[body]});
}

void Pipeline::play(const Scene& scene)
{
    Played& p = *played_;
    if (scene.size() < p.bodies)
        throw Error(ErrorKind::usage, fmt::format("the scene has {} bodies, {} in the last call; pass the same scene",
                                                  scene.size(), p.bodies));
    play_geometries(scene);
    ++p.calls;
    std::uint32_t body = 0;
    try {
        if (scene.changes.reaches(p.changes)) {
            for (const ChangeLog::Change change : scene.changes.since(p.changes)) {
                if (body = change.body; body >= p.bodies) continue;
                change.only_pose ? move_body(scene, body) : change_body(scene, body);
            }
        } else {
            for (body = 0; body < p.bodies; ++body) change_body(scene, body);
        }
        if (p.bodies == 0) world_.bodies().reserve(scene.size());
        for (body = p.bodies; body < scene.size(); ++body, ++p.bodies) add_body(scene, body);
    } catch (const Error& error) { // the World does not know the bodies' names
        const std::string_view what = error.what();
        const std::size_t colon = what.find(": ");
        const bool of_body = what.starts_with("body ") || what.starts_with("new body");
        const std::string name =
            scene.names[body].empty() ? fmt::format("body {}", body) : fmt::format("body '{}'", scene.names[body]);
        throw Error(error.kind(), of_body ? fmt::format("{}{}", name, what.substr(colon)) : std::string(what));
    }
    p.changes = scene.changes.now();
    p.time = scene.time;
    for (; p.excluded < scene.excluded.size(); ++p.excluded)
        world_.bodies().exclude(world_.bodies().at(scene.excluded[p.excluded].a),
                                world_.bodies().at(scene.excluded[p.excluded].b));
}

} // namespace oncollide
