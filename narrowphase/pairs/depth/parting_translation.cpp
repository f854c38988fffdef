#include <algorithm>
#include <cmath>
#include <vector>

#include <oncollide/narrowphase/pairs/depth/depth_steps.hpp>
#include <oncollide/narrowphase/pairs/depth_bounds.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

namespace depth_bounds {

using Eigen::Isometry3d, Eigen::Vector3d;

namespace {

/// The highest point of a terrain's surface over a box of its frame; -infinity if there is none.
double highest_over(const Terrain& terrain, const Aabb& box)
{
    const Aabb& all = terrain.bounds();
    if ((box.max.head<2>().array() < all.min.head<2>().array()).any() ||
        (box.min.head<2>().array() > all.max.head<2>().array()).any())
        return -infinity;
    const auto column = [&](double x, int axis, std::uint32_t last) {
        const double at = std::floor((x - terrain.origin()[axis]) / terrain.spacing()[axis]);
        return static_cast<std::uint32_t>(std::clamp(at, 0.0, double(last)));
    };
    const std::uint32_t x0 = column(box.min.x(), 0, terrain.cells_x()), y0 = column(box.min.y(), 1, terrain.cells_y()),
                        x1 = std::min(column(box.max.x(), 0, terrain.cells_x()) + 1, terrain.cells_x()),
                        y1 = std::min(column(box.max.y(), 1, terrain.cells_y()) + 1, terrain.cells_y());
    constexpr std::uint64_t most_heights = 1 << 16;
    if (std::uint64_t{x1 - x0 + 1} * (y1 - y0 + 1) > most_heights) return terrain.bounds().max.z();
    double highest = -infinity;
    for (std::uint32_t y = y0; y <= y1; ++y)
        for (std::uint32_t x = x0; x <= x1; ++x)
            if (const double z = terrain.point(x, y).z(); z > highest) highest = z;
    return highest + terrain.error();
}

} // namespace

} // namespace depth_bounds

void set_parting(const PairTask& task, Penetration& found)
{
    if (decides_b_first(task)) { // both orders have the same bounds
        set_parting(task.swapped(), found), found.parting_along = -found.parting_along;
        return;
    }
    const PlacedPair placed(task);
    const LeastTranslation least =
        least_translation(ConvexDifference(task.a->convex(), task.b->convex(), placed.b_to_a, placed.slack), infinity);
    found.parting_lower = std::max(least.lower, 0.0) * (1 - placed.slack);
    found.parting_upper = std::max(least.upper, 0.0) * (1 + placed.slack);
    found.parting_along = task.pose_a->linear() * least.normal;
}

double parting_translation(const PairTask& task, std::span<const Eigen::Vector3d> normals)
{
    using namespace depth_bounds;
    const auto boxes_in = [&](const Isometry3d& frame) {
        const Isometry3d into = frame.inverse(Eigen::Isometry);
        return std::pair(task.a->bounds().box(into * *task.pose_a), task.b->bounds().box(into * *task.pose_b));
    };
    double least = infinity, size = 0;
    const auto along = [&](const Aabb& a, const Aabb& b, int axis, bool up_only, bool b_up) {
        size = std::max({size, a.diagonal(), b.diagonal(), a.min.cwiseAbs().maxCoeff(), b.max.cwiseAbs().maxCoeff()});
        if (!up_only || b_up) least = std::min(least, a.max[axis] - b.min[axis]);
        if (!up_only || !b_up) least = std::min(least, b.max[axis] - a.min[axis]);
    };
    const bool a_below = task.a->kind() == Kind::terrain, b_below = task.b->kind() == Kind::terrain;
    if (a_below || b_below) {
        auto [a, b] = boxes_in(a_below ? *task.pose_a : *task.pose_b);
        Aabb &ground = a_below ? a : b, &body = a_below ? b : a;
        const double slack = rigid * body.diagonal();
        const Aabb wide{body.min.array() - slack, body.max.array() + slack};
        ground.max.z() =
            std::min(ground.max.z(), highest_over(a_below ? *task.a->terrain() : *task.b->terrain(), wide));
        along(a, b, 2, true, a_below);
    } else {
        std::vector<Isometry3d> frames{*task.pose_a, *task.pose_b, Isometry3d::Identity()};
        for (const Vector3d& n : normals) frames.emplace_back(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n));
        for (const Isometry3d& frame : frames) {
            Isometry3d at = frame;
            at.translation() = task.pose_a->translation();
            const auto [a, b] = boxes_in(at);
            for (int axis = 0; axis < 3; ++axis) along(a, b, axis, false, false);
        }
    }
    if (!(least > -size)) return 0;
    const double slack = slack_of(task) + rigid;
    return std::max(least + slack * std::abs(least) + 0x1p-44 * size, 0.0);
}

} // namespace oncollide
