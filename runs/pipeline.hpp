#pragma once
#include <memory>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Plays a Scene (a description) in a World (the simulation state).
///
///     Pipeline pipeline(scene, {.depth = 6});
///     for (...) { mover.move(scene, frame); for (const PairResult& pair : pipeline.step(scene).pairs) ... }
///
/// Body i of the scene is the body in slot i of the World, geometry i the model in slot i; geometries are shared, not
/// copied. A mesh that deforms passes its vertices by Models::set_vertices() in the frames in which they change.
class ONCOLLIDE_API Pipeline {
public:
    /// Throws the errors of World, but bodies have their scene names. Keeps only the geometries of `scene`.
    explicit Pipeline(const Scene& scene, const Settings& settings = {});
    /// @param world  a new World. Throws Error{usage} if it has models or bodies.
    Pipeline(const Scene& scene, World world);
    ~Pipeline();
    Pipeline(Pipeline&&) noexcept;

    /// Applies the changes of `scene` since the last call (poses, layers, groups, geometries, new bodies) to the World
    /// and runs a frame. Cost: proportional to the changes; if `scene` is another object than in the last call, even a
    /// copy, one comparison per body.
    FrameView step(const Scene& scene);

    /// From now on, step() moves bodies from their poses to the new ones by Bodies::set_motion(), so contacts on the
    /// way are reported: straight, but through the keys between the times of the last step and this one (Scene::time).
    /// Default: off. step() then throws Error{usage} if a geometry deforms.
    void set_continuous(bool continuous) { continuous_ = continuous; }
    bool continuous() const { return continuous_; }

    World& world() { return world_; }
    const World& world() const { return world_; }

    BodyId body(SceneBodyId body) const { return world_.bodies().at(index(body)); }
    ModelId model(GeometryId geometry) const { return world_.models().at(index(geometry)); }

    std::span<const std::string_view> stages() const { return all_stage_names(); }
    std::uint64_t hash() const { return world_.hash(); }
    WorldInfo inspect() const { return world_.inspect(); }
    const Settings& settings() const { return world_.settings(); }

private:
    struct ONCOLLIDE_LOCAL Played; ///< the parts of the scene that the World already has
    void play(const Scene& scene);
    void play_geometries(const Scene& scene);
    void add_body(const Scene& scene, std::uint32_t body);
    void change_body(const Scene& scene, std::uint32_t body);
    void move_body(const Scene& scene, std::uint32_t body);

    World world_;
    std::unique_ptr<Played> played_;
    bool continuous_ = false;
};

} // namespace oncollide
