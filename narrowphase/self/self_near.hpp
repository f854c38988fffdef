#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The pairs of features of a mesh at most `dhat` apart that are not neighbours, as Models::near_features().
/// @param vertex  for each vertex, the first one at its position
std::vector<NearFeatures> self_near(const Mesh& mesh, std::span<const std::uint32_t> vertex, double dhat,
                                    const SelfNearOptions& options, int threads);

} // namespace oncollide
