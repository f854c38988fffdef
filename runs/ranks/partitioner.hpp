#pragma once
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/runs/ranks/ranks.hpp>

namespace oncollide {

/// Divides space into one region per rank; all ranks have the same regions. Before the first rebuild(), all space is
/// rank 0's.
class Partitioner {
public:
    virtual ~Partitioner() = default;
    /// Divides anew, with roughly equal weights in all regions. Collective.
    /// @param points  the points of this rank
    /// @param weights  the weights of these points, > 0
    virtual void rebuild(Ranks& ranks, std::span<const Eigen::Vector3d> points, std::span<const float> weights) = 0;

    /// The rank whose region contains the point. Every point has exactly one owner, the same on all ranks.
    virtual int owner(const Eigen::Vector3d& point) const = 0;
    /// Overwrites `ranks` with at least the ranks whose regions the closed box touches, so the owner of every point of
    /// the box is included. Ascending.
    virtual void ranks(const Aabb& box, std::vector<int>& ranks) const = 0;
};

/// Regions are ranges of an octree's cells in Morton order, split by samples from all ranks.
std::unique_ptr<Partitioner> make_morton_partitioner();

} // namespace oncollide
