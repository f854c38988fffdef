// Pairs of meshes and their poses, for tests of OBB trees and traversals.
#pragma once
#include <vector>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide::mesh_cases {

using Eigen::Isometry3d;
using Eigen::Vector3d;

inline Mesh scaled(const Mesh& mesh, double scale, const Vector3d& by = Vector3d::Zero())
{
    return transformed("scaled", mesh, scale, -by / scale);
}

inline Mesh flat_copies()
{
    // Duplicates, triangles that are segments and points, and two far apart.
    std::vector<Vector3d> v{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.3, 0.3}};
    std::vector<Triangle> t;
    for (int i = 0; i < 9; ++i) t.insert(t.end(), {{0, 1, 2}, {0, 1, 1}, {3, 3, 3}, {0, 2, 3}, {1, 4, 3}});
    return make_mesh("copies", v, t);
}

struct Case {
    const char* name;
    Mesh a, b;
    double reach; ///< of the poses
};

inline std::vector<Case> cases()
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300), box = make_box_mesh({0.5, 0.5, 0.5});
    const Mesh needles = make_needles_mesh(60, 1, 1e4, 2, 5), soup = make_soup_mesh(120, 0.5, 1.5, 6);
    return {{"knots", knot, knot, 1.6},
            {"boxes", box, box, 1.3},
            {"needles and soup", needles, soup, 2.2},
            {"large and small", scaled(box, 8), scaled(soup, 0.2), 4.3},
            {"tiny", scaled(knot, 1e-7), scaled(soup, 1e-7), 1.4e-7},
            {"huge", scaled(knot, 1e9), scaled(soup, 1e9), 1.4e9},
            {"a triangle and a quad", make_soup_mesh(1, 1, 0.5, 3), make_soup_mesh(2, 1, 0.2, 4), 0.8},
            {"duplicates and triangles without area", flat_copies(), soup, 1.2},
            {"a file far from its origin", scaled(knot, 1, {1e4, -1e4, 1e3}), soup, 1.4}};
}

/// Poses of `b` near the centre of `a`.
inline std::vector<Isometry3d> poses_of(const Case& c, std::uint64_t count)
{
    std::vector<Isometry3d> poses;
    for (std::uint64_t seed = 0; seed < count; ++seed) {
        poses.push_back(random_pose(seed, c.reach));
        poses.back().translation() += c.a.bounds.centre();
    }
    return poses;
}

inline RelativePose at(const Isometry3d& b)
{
    return {Isometry3d::Identity(), b};
}

} // namespace oncollide::mesh_cases
