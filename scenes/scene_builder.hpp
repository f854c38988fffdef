#pragma once
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Builds a scene for its reader or generator, body by body: stores it as a Scene, or hands the bodies to a sink.
/// Private to the project.
class SceneBuilder {
public:
    // Both keep references.
    SceneBuilder(Scene& scene) : info_(scene), scene_(&scene) {}
    SceneBuilder(SceneInfo& info, BodySink& sink) : info_(info), sink_(&sink) {}

    operator SceneInfo&() { return info_; }
    const GeometryList& geometries() const { return info_.geometries; }
    std::vector<std::string>& warnings() { return info_.warnings; }
    std::size_t size() const { return info_.size(); }
    bool has_sink() const { return sink_; }
    bool wants(std::size_t body) const { return !sink_ || sink_->wants(static_cast<std::uint32_t>(body)); }
    /// True if the sink does not want the next body. That body then counts as added, and need not be constructed.
    bool skip_body() { return !wants(size()) && ++info_.size_; }

    // As the functions of Scene, except: with a sink, names of bodies may be equal and are not found, and the bodies of
    // a recording are only counted.
    GeometryId add(std::string name, GeometryData data, std::string recipe = {})
    {
        return info_.add(std::move(name), std::move(data), std::move(recipe));
    }
    std::optional<GeometryId> find_geometry(std::string_view name) const { return info_.find_geometry(name); }
    SceneBodyId add_body(BodyInit body);
    void reserve(std::size_t bodies);
    void record(std::shared_ptr<Recording> poses);
    void exclude(SceneBodyId a, SceneBodyId b);
    std::optional<SceneBodyId> find(std::string_view body) const;

private:
    SceneInfo& info_;
    Scene* scene_ = nullptr;
    BodySink* sink_ = nullptr;
};

} // namespace oncollide
