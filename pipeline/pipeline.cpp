#include <oncollide/pipeline/pipeline.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>

namespace oncollide {

struct Pipeline::Played {
    std::vector<std::shared_ptr<const Geometry>> geometries;
    std::vector<GeometryId> geometry;
    std::vector<Eigen::Isometry3d> poses;
    std::vector<std::uint8_t> is_static;
    std::vector<std::uint32_t> layers, masks, groups;
    std::size_t excluded = 0; ///< pairs
};

Pipeline::Pipeline(const Scene& scene, const Settings& settings, std::unique_ptr<OcclusionBackend> backend)
    : world_(settings, std::move(backend)), played_(std::make_unique<Played>())
{
    play(scene);
}
Pipeline::Pipeline(const Scene& scene, const Settings& settings) : Pipeline(scene, settings, nullptr) {}
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
    if (scene.geometries.size() < known.size())
        throw Error(ErrorKind::usage, fmt::format("the scene has {} geometries, {} before: it is another one",
                                                  scene.geometries.size(), known.size()));
    for (std::uint32_t g = 0; g < scene.geometries.size(); ++g) {
        const std::shared_ptr<const Geometry>& geometry = scene.geometries.share(g);
        if (g == known.size())
            world_.add(geometry), known.push_back(geometry);
        else if (known[g] != geometry)
            world_.replace(ModelId{g}, geometry), known[g] = geometry;
    }
}

void Pipeline::play_body(const Scene& scene, std::uint32_t body)
{
    Played& p = *played_;
    const BodyId id{body};
    const ModelId model{index(scene.geometry[body])};
    if (body == p.poses.size()) {
        world_.add_body({.model = model,
                         .pose = scene.poses[body],
                         .fixed = scene.is_static[body] != 0,
                         .layer = scene.layers[body],
                         .mask = scene.masks[body],
                         .group = scene.groups[body]});
        p.geometry.push_back(scene.geometry[body]), p.poses.push_back(scene.poses[body]);
        p.is_static.push_back(scene.is_static[body]), p.layers.push_back(scene.layers[body]);
        p.masks.push_back(scene.masks[body]), p.groups.push_back(scene.groups[body]);
        return;
    }
    if (p.poses[body].matrix() != scene.poses[body].matrix()) {
        world_.set_pose(id, scene.poses[body]);
        p.poses[body] = scene.poses[body];
    }
    if (p.geometry[body] != scene.geometry[body]) world_.set_model(id, model), p.geometry[body] = scene.geometry[body];
    if (p.is_static[body] != scene.is_static[body])
        world_.set_fixed(id, scene.is_static[body] != 0), p.is_static[body] = scene.is_static[body];
    if (p.layers[body] != scene.layers[body] || p.masks[body] != scene.masks[body]) {
        world_.set_layers(id, scene.layers[body], scene.masks[body]);
        p.layers[body] = scene.layers[body], p.masks[body] = scene.masks[body];
    }
    if (p.groups[body] != scene.groups[body])
        world_.set_group(id, scene.groups[body]), p.groups[body] = scene.groups[body];
}

void Pipeline::play(const Scene& scene)
{
    Played& p = *played_;
    if (scene.size() < p.poses.size())
        throw Error(ErrorKind::usage,
                    fmt::format("the scene has {} bodies, {} before: it is another one", scene.size(), p.poses.size()));
    play_geometries(scene);
    std::uint32_t body = 0;
    try {
        for (; body < scene.size(); ++body) play_body(scene, body);
    } catch (const Error& error) { // the World knows no names
        const std::string_view what = error.what();
        const std::size_t colon = what.find(": ");
        const bool of_body = what.starts_with("body ") || what.starts_with("new body");
        const std::string name =
            scene.names[body].empty() ? fmt::format("body {}", body) : fmt::format("body '{}'", scene.names[body]);
        throw Error(error.kind(), of_body ? fmt::format("{}{}", name, what.substr(colon)) : std::string(what));
    }
    for (; p.excluded < scene.excluded.size(); ++p.excluded)
        world_.exclude({scene.excluded[p.excluded].a}, {scene.excluded[p.excluded].b});
}

} // namespace oncollide
