#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/gl/picture.hpp>
#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// The sphere-tree of a geometry; null if there is none.
using TreeOf = std::function<const Ocst*(GeometryId)>;

/// A picture with its meshes that would not outlive it: parts, and meshes that deform.
struct ScenePicture : Picture {
    std::vector<std::shared_ptr<const Mesh>> own;
};

/// Turns a scene, its sphere-trees and its verdicts into pictures.
class ScenePictures {
public:
    struct Shown {
        bool meshes = true, spheres = true;
        std::vector<std::uint8_t> bodies; ///< by body
        double clearance = 0;
        bool meeting = false; ///< draw intersecting triangles of colliding meshes red; for exact predicates
    };
    /// `scene` must outlive it; poses may change.
    ScenePictures(const Scene& scene, Shown shown);

    /// The scene at its current poses, without a camera.
    /// @param world  the scene's World after this frame
    /// @param pairs  the pairs of this frame
    /// @param level  level of the spheres; nullopt: the finest known level everywhere
    ScenePicture make(const World& world, const TreeOf& tree_of, std::span<const PairResult> pairs,
                      std::optional<int> level);
    /// Spheres of the last picture, and how many of them are red.
    std::size_t spheres() const { return spheres_; }
    std::size_t red() const { return red_; }
    /// Triangles of the last picture that meet one of another body.
    std::size_t meeting() const { return meeting_; }

private:
    /// A sphere of a body, in the world frame.
    struct Sphere {
        Eigen::Vector3d centre;
        double radius;
        float fineness; ///< level / depth of the tree: 1 for leaves
        bool may_touch; ///< may turn red: a leaf, or any sphere if a level is given
        bool red = false;
    };
    const Mesh* mesh_of(GeometryId geometry);
    const std::vector<Sphere>& spheres_of(std::uint32_t body, const TreeOf& tree_of, std::optional<int> level);
    void add_spheres(Picture& picture, std::uint32_t body);
    void mark_touching(std::uint32_t a, std::uint32_t b);
    void find_meeting(const World& world, std::span<const PairResult> pairs);
    void add_mesh(ScenePicture& picture, std::uint32_t body);

    const Scene& scene_;
    Shown shown_;
    std::vector<std::unique_ptr<Mesh>> made_;                 ///< by geometry: of shapes, maps and terrains
    std::vector<std::optional<std::vector<Sphere>>> of_body_; ///< sorted along x; none: not needed yet
    std::vector<std::vector<std::uint32_t>> meeting_of_;      ///< by body: its triangles that meet others, ascending
    std::size_t spheres_ = 0, red_ = 0, meeting_ = 0;
};

} // namespace oncollide::tools
