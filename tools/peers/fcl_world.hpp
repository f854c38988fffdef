#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// What FCL answers for one frame. Valid until the next step.
struct FclFrame {
    std::span<const BodyPair> colliding; ///< sorted
    std::uint64_t contacts = 0;          ///< where they were requested
    std::uint64_t candidates = 0;        ///< pairs whose boxes overlap and whose layers allow it
    double transforms_ms = 0;            ///< poses and world boxes
    double update_ms = 0;                ///< the trees of boxes
    double pairs_ms = 0;                 ///< finding candidates
    double narrow_ms = 0;                ///< fcl::collide on each
    double ms() const { return transforms_ms + update_ms + pairs_ms + narrow_ms; }
};

/// The same query to FCL, as well as FCL can be used: one model a geometry (oriented boxes, the fastest for
/// yes and no), one tree of boxes over what moves and one over what does not, no contacts. The peer of the benchmarks
/// and the judge of the tests; it shares no code with the exact level of the pipeline.
class FclWorld {
public:
    /// Octrees of the scene's maps, by geometry: what a program has that reads maps for FCL.
    using Octrees = std::vector<std::shared_ptr<const octomap::OcTree>>;
    static Octrees octrees_of(const Scene& scene);
    /// Builds every model and object. Keeps a reference to `scene`.
    explicit FclWorld(const Scene& scene) : FclWorld(scene, octrees_of(scene)) {}
    FclWorld(const Scene& scene, const Octrees& octrees);
    ~FclWorld();

    /// @param contacts  find every contact of each pair, instead of a yes or no
    FclFrame step(bool contacts = false);

    /// Do two bodies collide at the scene's poses? The last step plays no part.
    bool collides(BodyPair pair) const;
    /// Their distance there, 0 when they touch (m). Models for it are made when first needed; FCL
    /// rounds it by about 1e-9 of the bodies' size between meshes, and by 1e-6 where a primitive shape takes part.
    double distance(BodyPair pair);
    /// How deep the bodies overlap, as the largest of FCL's contacts says (m); 0 when they do not.
    double penetration(BodyPair pair) const;

    /// Is one of the two a primitive shape? FCL uses libccd then, which stops within 1e-6 of the answer.
    bool has_shape(BodyPair pair) const;

    /// Bytes of the mesh models: nodes, triangles, vertices. Objects, their tree of boxes and maps are not in it.
    struct ModelBytes {
        std::size_t obb = 0, obbrss = 0; ///< as they are, and as they would be with its other kind of nodes
    };
    ModelBytes model_bytes() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide::tools
