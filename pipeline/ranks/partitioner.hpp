#pragma once
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/pipeline/ranks/ranks.hpp>

namespace oncollide {

/// Cuts space into regions, one for each rank, which all ranks know alike. Before the first rebuild() all is rank 0's.
class Partitioner {
public:
    virtual ~Partitioner() = default;
    virtual std::string_view name() const = 0;

    /// Cuts anew, so that the weights in the regions are much the same. A call of all ranks.
    /// @param points  this rank's
    /// @param weights of these, > 0
    virtual void rebuild(Ranks& ranks, std::span<const Eigen::Vector3d> points, std::span<const float> weights) = 0;

    /// The rank whose region holds the point. Every point has one, on whatever rank one looks.
    virtual int owner(const Eigen::Vector3d& point) const = 0;
    /// Overwrites `ranks` with those whose regions the closed box touches, at least: for every point of the box its
    /// owner is among them. Ascending.
    virtual void ranks(const Aabb& box, std::vector<int>& ranks) const = 0;
};

/// Regions are runs of the cells of an octree in Morton order, split by samples of all ranks.
std::unique_ptr<Partitioner> make_morton_partitioner();
/// Zoltan's recursive coordinate bisection. With ONCOLLIDE_MPI=OFF, or for ranks that are not of MPI, it throws
/// Error{usage}.
std::unique_ptr<Partitioner> make_zoltan_partitioner(const Ranks& ranks);

} // namespace oncollide
