#pragma once
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// For the truth: all pairs of bodies that may collide and whose world AABBs, of all vertices and rounded generously,
/// are within `clearance`; sorted. Found by a sweep along x.
std::vector<BodyPair> near_bodies(const Scene& scene, double clearance);

} // namespace oncollide::tools
