#pragma once
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// For the truth: every two bodies whose world boxes are within `clearance`, of all vertices and generously rounded,
/// and that may collide; sorted. By a sweep along x.
std::vector<BodyPair> near_bodies(const Scene& scene, double clearance);

} // namespace oncollide::tools
