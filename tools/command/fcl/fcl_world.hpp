#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// FCL's results for one frame. Valid until the next step.
struct FclFrame {
    std::span<const BodyPair> colliding; ///< sorted
    std::uint64_t contacts = 0;          ///< if requested
    std::uint64_t candidates = 0;        ///< pairs with overlapping AABBs that layers allow
    double transforms_ms = 0;            ///< poses and world AABBs
    double update_ms = 0;                ///< update of the trees of AABBs
    double pairs_ms = 0;                 ///< finding candidates
    double narrow_ms = 0;                ///< fcl::collide on each
    double ms() const { return transforms_ms + update_ms + pairs_ms + narrow_ms; }
};

/// The same query with FCL, used as well as possible: one model per geometry (OBBs, the fastest for collision queries),
/// one tree of AABBs for moving and one for static objects, no contacts. The peer in benchmarks;
/// shares no code with the pipeline's exact level.
class FclWorld {
public:
    /// Octrees of the scene's maps, by geometry, as a program has them that reads maps for FCL.
    using Octrees = std::vector<std::shared_ptr<const octomap::OcTree>>;
    static Octrees octrees_of(const Scene& scene);
    /// Builds every model and object. Keeps a reference to `scene`.
    explicit FclWorld(const Scene& scene) : FclWorld(scene, octrees_of(scene)) {}
    FclWorld(const Scene& scene, const Octrees& octrees);
    ~FclWorld();

    /// @param contacts  find all contacts of each pair, not only whether it collides
    FclFrame step(bool contacts = false);

    /// The distance of two bodies at the scene's current poses, 0 if they touch (m). Its models are made on first use.
    /// FCL rounds it by about 1e-9 of the bodies' size between meshes, and by 1e-6 if a shape takes part.
    double distance(BodyPair pair);

    /// Bytes of the mesh models: nodes, triangles, vertices; without objects, their trees of AABBs, and maps.
    struct ModelBytes {
        std::size_t obb = 0, obbrss = 0; ///< obb: actual; obbrss: with the other kind of nodes
    };
    ModelBytes model_bytes() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide::tools
