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

/// The right results of a frame, by nothing that is under test: the boxes of every two bodies are compared, and every
/// two meshes whose boxes overlap are decided by exact arithmetic on their triangles (tools/hard). Solid mode: by
/// winding numbers. A terrain is the mesh of its heights as stored. Where a shape or a map takes part: the distance of
/// convex sets, in extended precision, and of half-spaces from the points that reach farthest into them.
class StudyTruth {
public:
    /// Clearance, mode and whether touching counts are taken from `request`. Keeps a reference to `scene`.
    StudyTruth(const Scene& scene, const Settings& request);
    ~StudyTruth();

    /// At the scene's poses.
    void step();
    /// Pairs that collide, or are within the clearance, sorted.
    const std::vector<BodyPair>& colliding() const { return colliding_; }
    bool collide(BodyPair pair) const;
    /// So near the clearance that rounding decides: either result is right.
    bool open(BodyPair pair) const;
    /// Of this frame: between meshes in long double, less what the pipeline's own bounds may round by.
    DistanceTruth distance(BodyPair pair);

private:
    enum class Decision : std::uint8_t { apart, open, collide };
    struct Model;
    const Model* model(std::uint32_t body) const; ///< null: no mesh and no terrain
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
