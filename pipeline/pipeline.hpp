#pragma once
#include <memory>
#include <vector>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Plays a Scene (a description) in a World (the simulation state).
///
///     Pipeline pipeline(scene, {.depth = 6});
///     for (...) { mover.move(scene, frame); for (const PairResult& pair : pipeline.step(scene).pairs) ... }
///
/// Body i of the scene is BodyId{i} of the World, geometry i its ModelId{i}; geometries are shared, not copied.
class Pipeline {
public:
    /// Errors as World's, but bodies have their scene names. Keeps only the geometries of `scene`.
    explicit Pipeline(const Scene& scene, const Settings& settings = {});
    Pipeline(const Scene& scene, const Settings& settings, std::unique_ptr<OcclusionBackend> backend);
    ~Pipeline();
    Pipeline(Pipeline&&) noexcept;

    /// Applies the changes of `scene` since the last call (poses, layers, groups, geometries, new bodies) to the World
    /// and runs a frame. Cost: proportional to the changes; if `scene` is another object than in the last call, even a
    /// copy, one comparison per body.
    FrameView step(const Scene& scene);

    World& world() { return world_; }
    const World& world() const { return world_; }

    std::span<const std::string_view> stages() const { return world_.stages(); }
    std::span<const StageStats> totals() const { return world_.totals(); }
    std::uint64_t hash() const { return world_.hash(); }
    std::string backend() const { return world_.backend(); }
    std::string renderer() const { return world_.renderer(); }
    std::string backend_note() const { return world_.backend_note(); }
    const Settings& settings() const { return world_.settings(); }
    const Ocst* tree(GeometryId geometry) const { return world_.tree({index(geometry)}); }

private:
    struct Played; ///< the parts of the scene that the World already has
    void play(const Scene& scene);
    void play_geometries(const Scene& scene);
    void add_body(const Scene& scene, std::uint32_t body);
    void change_body(const Scene& scene, std::uint32_t body);

    World world_;
    std::unique_ptr<Played> played_;
};

} // namespace oncollide
