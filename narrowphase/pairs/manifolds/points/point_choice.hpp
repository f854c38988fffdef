#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/points/candidate.hpp>

namespace oncollide {

/// Chooses the points among a region's candidates. Keeps its memory.
class PointChoice {
public:
    /// Indices of the candidates to keep: the deepest, the farthest from the deepest, the third corner of the largest
    /// triangle, then always the candidate that adds the most area. Does not depend on the order of the candidates.
    /// @param all   at least one
    /// @param most  at least 1
    const std::vector<std::uint32_t>& choose(const std::vector<ManifoldCandidate>& all, const Eigen::Vector3d& normal,
                                             std::size_t most);

private:
    void take(auto value, double least, double tie);
    void find_edges();

    const std::vector<ManifoldCandidate>* all_ = nullptr;
    std::vector<Eigen::Vector2d> flat_; ///< across the normal
    std::vector<double> values_;
    std::vector<std::uint32_t> kept_;
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> edges_;
    double size_ = 0;
};

} // namespace oncollide
