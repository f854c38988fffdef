#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/scene.hpp>

#include "render/framing.hpp"
#include "render/png.hpp"
#include "render/shading.hpp"

namespace oncollide::tools {

/// Draws the bodies of a scene by casting segments from the eye, four for each pixel. Needs no OpenGL, draws no
/// triangles of its own and reads only the chunks of cooked files that are seen.
class RayPictures {
public:
    /// @param shown  for each body, true if it is drawn
    RayPictures(const Scene& scene, const Settings& settings, const std::vector<std::uint8_t>& shown);

    /// Takes the scene's current poses and vertices.
    void move(const Scene& scene);
    /// Adds the AABBs of the shown bodies; half-spaces have none.
    void frame(Framing& framing) const;
    Image draw(const Camera& camera, int width, int height);

    std::uint64_t rays() const { return rays_; } ///< number of rays in all pictures
    std::uint64_t hits() const { return hits_; }
    double milliseconds() const { return ms_; } ///< time of the casts

private:
    struct Row {
        std::uint32_t body; ///< in the scene
        BodyId id;
    };
    void cast(const std::vector<Segment>& segments, std::vector<CastHit>& hits);
    double view_length(const Eigen::Vector3d& eye) const;

    const Scene& scene_;
    World world_;
    GeometryList geometries_;     ///< as the World has them
    std::vector<ModelId> models_; ///< by geometry; null: no body shows it
    std::vector<Row> rows_;       ///< rows of the shown bodies
    std::vector<Colour> colours_; ///< by slot in the World
    bool unbounded_ = false;
    std::uint64_t rays_ = 0, hits_ = 0;
    double ms_ = 0;
};

} // namespace oncollide::tools
