#pragma once
#include <map>
#include <vector>

#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/pipeline.hpp>

#include "fcl_world.hpp"

namespace oncollide::tools {

/// The right answers to a frame. Every pair of boxes is compared, and every pair that overlaps is decided by the exact
/// predicates, with no stage between; FCL is asked where a shape or a map takes part.
class StudyTruth {
public:
    /// Clearance and mode are taken from `asked`. All must outlive it.
    StudyTruth(const Scene& scene, const Settings& asked, FclWorld& world);

    /// At the scene's poses.
    void step();
    /// Pairs that collide, or are within the clearance, sorted.
    const std::vector<BodyPair>& colliding() const { return colliding_; }
    bool collide(BodyPair pair) const;
    /// Of this frame: certified between meshes, else FCL's.
    MeshDistance distance(BodyPair pair);

private:
    const Scene& scene_;
    Pipeline pipeline_;
    ContactFinder contacts_;
    FclWorld& world_;
    std::vector<BodyPair> colliding_;
    std::map<BodyPair, MeshDistance> known_;
};

} // namespace oncollide::tools
