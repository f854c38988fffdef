#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Which features of a mesh are neighbours of each other; see SelfNearOptions.
struct NeighbourRule {
    std::uint32_t rings = 1; ///< at least 1
    std::span<const Eigen::Vector3d> rest{};
    double rest_distance = 0;
};

/// The pairs of features of a mesh at most `dhat` apart that are not neighbours, as Models::near_features().
/// @param vertex  for each vertex, the first one at its position
std::vector<NearFeatures> self_near(const Mesh& mesh, std::span<const std::uint32_t> vertex, double dhat,
                                    const NeighbourRule& rule, int threads);

} // namespace oncollide
