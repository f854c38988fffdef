#include <oncollide/pipeline/two_geometries.hpp>

#include <fmt/format.h>

#include <oncollide/narrowphase/pairs/triangle_pairs.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>

namespace oncollide {

namespace {

void check_pose(const char* which, const Eigen::Isometry3d& pose)
{
    WorldImpl::check_pose(fmt::format("pose {}: ", which).c_str(), pose);
}

/// Checks two meshes and their poses, then makes the meshes' OBB trees: meshes need no World.
struct TwoTrees {
    ObbTree a, b;

    static const Mesh& checked(const char* which, const Mesh& mesh, const Eigen::Isometry3d& pose)
    {
        check_pose(which, pose);
        check_mesh(fmt::format("mesh {}", which), mesh);
        return mesh;
    }
    TwoTrees(const Mesh& mesh_a, const Eigen::Isometry3d& pose_a, const Mesh& mesh_b, const Eigen::Isometry3d& pose_b)
        : a(checked("a", mesh_a, pose_a)), b(checked("b", mesh_b, pose_b))
    {
    }
};

/// A World of two models at poses.
struct TwoModels {
    World world;
    PlacedModel a, b;

    static ModelId add(World& world, const char* which, const GeometryArgument& geometry, const Eigen::Isometry3d& pose)
    {
        check_pose(which, pose);
        if (geometry.mesh()) return world.models().add(*geometry.mesh(), fmt::format("mesh {}", which));
        return world.models().add(geometry.geometry());
    }
    TwoModels(const GeometryArgument& geometry_a, const Eigen::Isometry3d& pose_a, const GeometryArgument& geometry_b,
              const Eigen::Isometry3d& pose_b)
        : a{add(world, "a", geometry_a, pose_a), pose_a}, b{add(world, "b", geometry_b, pose_b), pose_b}
    {
    }
};

} // namespace

Finding collide(const GeometryArgument& a, const Eigen::Isometry3d& pose_a, const GeometryArgument& b,
                const Eigen::Isometry3d& pose_b)
{
    if (!a.mesh() || !b.mesh()) {
        const TwoModels two(a, pose_a, b, pose_b);
        return two.world.pairs().decide(two.a, two.b);
    }
    TwoTrees trees(*a.mesh(), pose_a, *b.mesh(), pose_b);
    Traversal walk;
    const auto [meeting, bound] = walk.first_meeting(trees.a, trees.b, RelativePose(pose_a, pose_b));
    return {meeting ? Verdict::colliding : Verdict::separate, ContactKind::unknown, bound};
}

Distance distance(const GeometryArgument& a, const Eigen::Isometry3d& pose_a, const GeometryArgument& b,
                  const Eigen::Isometry3d& pose_b, const DistanceOptions& options)
{
    check_distance(options);
    if (!a.mesh() || !b.mesh()) {
        const TwoModels two(a, pose_a, b, pose_b);
        return two.world.pairs().distance(two.a, two.b, options);
    }
    TwoTrees trees(*a.mesh(), pose_a, *b.mesh(), pose_b);
    Traversal walk;
    return triangle_distance(walk, trees.a, pose_a, trees.b, pose_b, options);
}

std::vector<Contact> contacts(const GeometryArgument& a, const Eigen::Isometry3d& pose_a, const GeometryArgument& b,
                              const Eigen::Isometry3d& pose_b)
{
    if (!a.mesh() || !b.mesh()) {
        const TwoModels two(a, pose_a, b, pose_b);
        return two.world.pairs().contacts(two.a, two.b);
    }
    TwoTrees trees(*a.mesh(), pose_a, *b.mesh(), pose_b);
    Traversal walk;
    std::vector<TrianglePair> pairs;
    std::vector<Contact> found;
    triangle_contacts(walk, trees.a, pose_a, trees.b, pose_b, pairs, found);
    return found;
}

Penetration penetration(const GeometryArgument& a, const Eigen::Isometry3d& pose_a, const GeometryArgument& b,
                        const Eigen::Isometry3d& pose_b)
{
    const TwoModels two(a, pose_a, b, pose_b);
    return two.world.pairs().penetration(two.a, two.b);
}

} // namespace oncollide
