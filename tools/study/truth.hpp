#pragma once
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/scene.hpp>

#include "differential/convex_truth.hpp"
#include "hard/body_truth.hpp"

namespace oncollide::tools {

/// The correct results of a frame, computed without any code under test. All pairs of AABBs are compared, and meshes
/// whose AABBs overlap are decided by exact arithmetic on their triangles (tools/hard), in solid mode also by winding
/// numbers. A terrain is the mesh of its stored heights. For shapes and maps: distances of convex sets in extended
/// precision; for half-spaces: the points that reach farthest into them.
class StudyTruth {
public:
    /// Takes clearance, mode and the treatment of touching from `request`. Keeps a reference to `scene`.
    StudyTruth(const Scene& scene, const Settings& request);
    ~StudyTruth();

    /// Computes the results at the scene's poses.
    void step();
    /// Pairs that collide, or are within the clearance, sorted.
    const std::vector<BodyPair>& colliding() const { return colliding_; }
    bool collide(BodyPair pair) const;
    /// True if the pair is so near the clearance that rounding decides: both results are accepted.
    bool open(BodyPair pair) const;
    /// The distance in this frame: between meshes in long double, less the rounding that the pipeline's bounds may
    /// have.
    DistanceTruth distance(BodyPair pair);

private:
    enum class Decision : std::uint8_t { apart, open, collide };
    struct Model;
    const Model* model(std::uint32_t body) const; ///< null: neither mesh nor terrain
    Decision decide_meshes(BodyPair pair) const;
    Decision decide_other(BodyPair pair) const;
    DistanceTruth mesh_distance(BodyPair pair) const;
    DistanceTruth convex_distance(BodyPair pair) const;
    TrueDistance bounded_distance(BodyPair pair) const;
    bool holds_other(std::uint32_t outer, std::uint32_t inner) const;

    const Scene& scene_;
    Settings request_;
    std::vector<std::unique_ptr<Model>> models_; ///< by geometry
    std::vector<BodyPair> colliding_, open_;
    std::map<BodyPair, DistanceTruth> known_;
};

} // namespace oncollide::tools
