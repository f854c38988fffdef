// The surface of the common part of two meshes, against certified volumes and closed forms.
#include "clash/view/overlap_surface.hpp"

#include <gtest/gtest.h>

#include <oncollide/narrowphase/overlap/common_ball.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "plate_with_hole.hpp"
#include "random_pose.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

const Isometry3d here = Isometry3d::Identity();

Isometry3d shifted(const Vector3d& by)
{
    return Isometry3d(Eigen::Translation3d(by));
}

struct Found {
    CommonBall ball;
    std::vector<Corners> surface;
    double volume = 0, area = 0; ///< of the surface
};

Found find(const Mesh& a, const Isometry3d& pose_a, const Mesh& b, const Isometry3d& pose_b, std::size_t most = 100'000)
{
    World world;
    const BodyId body_a = world.bodies().add({.model = world.models().add(a), .pose = pose_a}),
                 body_b = world.bodies().add({.model = world.models().add(b), .pose = pose_b});
    Found found{.ball = common_ball(a, pose_a, b, pose_b, {.most_boxes_for_volume = 20'000, .relative_volume = .005}),
                .surface = {}};
    found.surface = overlap_surface({a, pose_a}, {b, pose_b}, world.pairs().contacts(body_a, body_b),
                                    2 * found.ball.radius_lower, most);
    for (const Corners& c : found.surface) {
        found.volume +=
            (c[0] - pose_a.translation()).dot((c[1] - pose_a.translation()).cross(c[2] - pose_a.translation())) / 6;
        found.area += (c[1] - c[0]).cross(c[2] - c[0]).norm() / 2;
    }
    return found;
}

TEST(OverlapSurface, EnclosesTheVolumeThatIsCertified)
{
    for (std::uint64_t seed = 0; seed < 36; ++seed) {
        const Mesh box = make_box_mesh({1, .3, .5}),
                   plate = plate_with_hole({-1, -1, -.2}, {1, 1, .2}, {-.5, -.4, 0}, {.5, .4, 0}),
                   ball = make_sphere_mesh(.6, 500);
        const Mesh* const meshes[] = {&box, &plate, &ball};
        const Mesh &a = *meshes[seed % 3], &b = *meshes[(seed / 3) % 3];
        const Found found = find(a, random_pose(2 * seed, .4), b, random_pose(2 * seed + 1, .4));
        if (found.ball.radius_lower == 0) continue;
        const double rounding = 1e-6 * found.ball.volume_upper;
        EXPECT_GE(found.volume, found.ball.volume_lower - rounding) << seed;
        EXPECT_LE(found.volume, found.ball.volume_upper + rounding) << seed;
    }
}

TEST(OverlapSurface, FacesInLineBelongToItWhereBothSolidsAreOnOneSide)
{
    const Mesh box = make_box_mesh({.5, .5, .5});
    // The common part of both is .25 x 1 x 1: four of its faces are in line with faces of both.
    const Found in_line = find(box, here, box, shifted({.75, 0, 0}));
    EXPECT_NEAR(in_line.volume, 2 * .25, .25 + 1e-12) << "faces in line may be there once or twice";
    EXPECT_GE(in_line.area, 2 * 1 + 4 * .25 - 1e-12);
    // Boxes that only share a face have nothing in common, and the judge of a film is the side.
    const Found film = find(box, here, box, shifted({1 - 1e-6, .2, .3}));
    EXPECT_NEAR(film.volume, 1e-6 * .8 * .7, 1e-12);
    EXPECT_NEAR(film.area, 2 * .8 * .7, 1e-5);
    EXPECT_TRUE(find(box, here, box, shifted({1.5, 0, 0})).surface.empty());
}

TEST(OverlapSurface, ABodyInsideIsWhole)
{
    const Mesh box = make_box_mesh({.5, .5, .5}), small = make_box_mesh({.1, .1, .1});
    EXPECT_NEAR(find(box, here, small, shifted({.2, .1, 0})).volume, .008, 1e-12);
    const Mesh plate = plate_with_hole({-1, -1, -.2}, {1, 1, .2}, {-.5, -.4, 0}, {.5, .4, 0});
    EXPECT_TRUE(find(plate, here, small, here).surface.empty()) << "in the hole";
}

TEST(OverlapSurface, IsEmptyBeyondItsLimit)
{
    const Mesh ball = make_sphere_mesh(1, 5000);
    EXPECT_GT(find(ball, here, ball, shifted({.5, 0, 0})).surface.size(), 1000);
    EXPECT_TRUE(find(ball, here, ball, shifted({.5, 0, 0}), 1000).surface.empty());
}

} // namespace
} // namespace oncollide::tools
