#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/manifolds/manifold_job.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_points.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

/// Regions of a shape and the triangles of a mesh, a terrain or a map. Keeps its memory between calls.
///
/// Each triangle in reach gives the least translation that parts it from the shape, or its own normal. Where the
/// direction leads across an edge or a corner that does not stick out, the triangle around it that rises there gives
/// the direction of the surface; then the triangle only adds points to the region of its own plane, if there is one.
/// Triangles with one direction in one plane, or around one corner, are one region.
class ConvexOnSurface {
public:
    /// True if one body is a round shape, a box or a hull, and the other one has triangles or cells.
    static bool takes(const PairTask& task);
    /// Appends the regions. False: nothing was appended, because a box or a hull is deep in the surface, holds all
    /// triangles in reach, or reaches many. Then the two surfaces must be compared.
    bool add(PairWorker& worker, const PairTask& task, const ManifoldJob& job, const RelativePose& b_to_a);

private:
    enum class Way : std::uint8_t {
        out,     ///< the direction leads out of the surface
        blocked, ///< a triangle rises in the direction
        none,    ///< the triangle has no region
        deep,    ///< the shape's middle is behind the surface
    };
    struct Reached {
        std::uint32_t triangle;
        std::array<std::uint32_t, 3> numbers; ///< of its corners
        TrianglePoints corners;
        Eigen::Vector3d face; ///< unit, outward; 0 without an area
        LeastTranslation least;
        double face_depth = 0; ///< how far the shape reaches below the face's plane
        bool apart = false;    ///< the triangle and the shape are certainly apart
        bool inside = false;   ///< they are, and the shape is inside the surface
        Way way = Way::none;
        std::uint32_t risen = 0; ///< the triangle that blocks the direction
    };
    struct Group {
        ContactPoints points;
        double lower, upper, normal_error, height; ///< height: of the points on the triangles along the normal
        bool apart;                                ///< no triangle meets the shape
        bool inside;                               ///< no triangle meets the shape, which is inside the surface
        std::uint32_t left_out;                    ///< points that were found and left out
    };
    struct Setup;
    bool find_reached(const Setup& s);
    Way set_way(Setup& s, Reached& r) const;
    void take_face(const Setup& s, Reached& r) const;
    std::uint32_t risen_triangle(const Setup& s, const Reached& r, const Eigen::Vector3d& n) const;
    bool gives_direction(const Reached& r) const;
    std::size_t group_of(const Setup& s, const Eigen::Vector3d& n, double height) const;
    void add_to_group(const Setup& s, const Reached& r);
    void add_points(const Setup& s, const Reached& r, Group& group);
    void add_blocked(const Setup& s);
    void add_region(const Setup& s, Group& group) const;

    std::vector<std::uint32_t> triangles_;
    std::vector<Reached> reached_;
    std::vector<Group> groups_;
    std::size_t group_count_ = 0;
    ContactFace face_; ///< the shape's, along a group's normal
    const Group* face_of_ = nullptr;
};

} // namespace oncollide
