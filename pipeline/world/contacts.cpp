// Two meshes at two poses, in one call.
#include <oncollide/pipeline/mesh_queries.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/pairs/triangle_pairs.hpp>
#include <oncollide/pipeline/check_distance.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

/// Checks the meshes and poses, then makes the meshes' OBB trees.
struct TwoTrees {
    ObbTree a, b;

    static const Mesh& checked(const char* which, const Mesh& mesh, const Eigen::Isometry3d& pose)
    {
        if (const std::string why = WorldAccess::why_refused(pose); !why.empty())
            throw Error(ErrorKind::bad_data, fmt::format("pose {}: {}", which, why));
        check_mesh(fmt::format("mesh {}", which), mesh);
        return mesh;
    }
    TwoTrees(const Mesh& mesh_a, const Eigen::Isometry3d& pose_a, const Mesh& mesh_b, const Eigen::Isometry3d& pose_b)
        : a(checked("a", mesh_a, pose_a)), b(checked("b", mesh_b, pose_b))
    {
    }
};

} // namespace

void check_distance(double tolerance, double farthest)
{
    for (const auto& [what, value] : {std::pair("tolerance", tolerance), std::pair("limit", farthest)})
        if (!(value >= 0))
            throw Error(ErrorKind::usage, fmt::format("distance: a {} of {}; must be 0 or more", what, value));
}

Finding collide(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b)
{
    TwoTrees trees(a, pose_a, b, pose_b);
    Traversal walk;
    const auto [meeting, bound] = walk.first_meeting(trees.a, trees.b, RelativePose(pose_a, pose_b));
    return {meeting ? Verdict::colliding : Verdict::separate, ContactKind::unknown, bound};
}

Distance distance(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b,
                  double tolerance, double farthest)
{
    check_distance(tolerance, farthest);
    TwoTrees trees(a, pose_a, b, pose_b);
    Traversal walk;
    return triangle_distance(walk, trees.a, pose_a, trees.b, pose_b, tolerance, farthest);
}

std::vector<Contact> contacts(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                              const Eigen::Isometry3d& pose_b)
{
    TwoTrees trees(a, pose_a, b, pose_b);
    Traversal walk;
    std::vector<TrianglePair> pairs;
    std::vector<Contact> found;
    triangle_contacts(walk, trees.a, pose_a, trees.b, pose_b, pairs, found);
    return found;
}

} // namespace oncollide
