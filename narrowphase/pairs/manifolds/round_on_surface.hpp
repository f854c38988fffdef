#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/manifolds/manifold_job.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_points.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

/// Regions of a round shape and the triangles of a mesh, a terrain or a map. Keeps its memory between calls.
///
/// Each triangle in reach gives the least translation that parts it from the shape. Triangles whose direction leads
/// across an edge or a corner that does not stick out are left out: there, a neighbour gives the direction of the
/// surface. Triangles with one direction in one plane, or around one corner, are one region.
class RoundOnSurface {
public:
    /// Appends the regions.
    void add(PairWorker& worker, const PairTask& task, const ManifoldJob& job, const RelativePose& b_to_a);

private:
    struct Reached {
        std::uint32_t triangle;
        TrianglePoints corners;
        Eigen::Vector3d face; ///< unit, outward; 0 without an area
        LeastTranslation least;
    };
    struct Group {
        ContactPoints points;
        double lower, upper, normal_error, height; ///< height: of the points on the triangles along the normal
    };
    struct Setup;
    void find_reached(const Setup& s);
    bool set_direction(const Setup& s, Reached& r) const;
    bool leads_out(const Setup& s, const Reached& r, const Eigen::Vector3d& n) const;
    void add_to_group(const Setup& s, const Reached& r);
    void add_region(const Setup& s, Group& group) const;

    std::vector<std::uint32_t> triangles_;
    std::vector<Reached> reached_;
    std::vector<Group> groups_;
    std::size_t group_count_ = 0;
};

} // namespace oncollide
