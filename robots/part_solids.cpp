#include <oncollide/robots/part_solids.hpp>

#include <algorithm>
#include <numbers>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

namespace {

Eigen::Vector3d box_inside(const Geometry& geometry)
{
    const Shape* const shape = std::get_if<Shape>(&geometry.data);
    if (const Box* const box = shape ? std::get_if<Box>(shape) : nullptr) return box->half;
    if (const Cylinder* const cylinder = shape ? std::get_if<Cylinder>(shape) : nullptr) {
        const double side = cylinder->radius / std::numbers::sqrt2;
        return {side, side, 0.5 * cylinder->length};
    }
    return Eigen::Vector3d::Constant(-1);
}

/// Share of the coordinates that covers poses up to 2^-20 from rigid, and rounding to float.
constexpr double pose_rounding = 0x1p-17;

} // namespace

PlacedBody::PlacedBody(std::uint32_t number, const Geometry& geometry, const Aabb& own_box,
                       const Eigen::Isometry3d& pose)
    : slot(number), box(own_box, pose), inside(box_inside(geometry))
{
}

bool surely_apart(const PartSolids& a, const Eigen::Isometry3d& pose_a, const PartSolids& b,
                  const Eigen::Isometry3d& pose_b, double clearance, Parting& parting)
{
    constexpr std::uint8_t most_in_vain = 7;
    if (parting.rest > 0) return --parting.rest, false;
    const RelativePose b_to_a(pose_a, pose_b);
    const double needed = clearance * (1 + pose_rounding);
    bool found = parting.held() && gap_along(a.hull, b.hull, b_to_a, parting.across.cast<double>()) > needed;
    if (!found) {
        // More than is needed: the direction should serve for other configurations, too.
        const double enough = 2 * needed + 0x1p-7 * (a.hull.extent() + b.hull.extent());
        const HullGap gap = hull_gap(a.hull, b.hull, b_to_a, parting.across, enough);
        parting.across = gap.across;
        found = gap.gap > needed;
    }
    parting.in_vain = found ? std::uint8_t{0} : std::min<std::uint8_t>(parting.in_vain + 1, most_in_vain);
    parting.rest = static_cast<std::uint8_t>((1u << parting.in_vain) - 1);
    return found;
}

namespace {

/// A part's hull, seen from a box.
struct SeenFromBox {
    const OuterHull& hull;
    const PlacedBox& box;
    RelativePose to_box;
    Eigen::Vector3d centre;
    double needed; ///< gap

    SeenFromBox(const PartSolids& a, const Eigen::Isometry3d& pose, const PlacedBox& to, double clearance)
        : hull(a.hull), box(to), to_box(to.pose, pose), centre(to_box(a.hull.centre()) - to.centre),
          needed((clearance + a.hull.cover()) * (1 + pose_rounding) + 0x1p-46 * to_box.translation.norm() +
                 pose_rounding * (a.hull.extent() + centre.cwiseAbs().sum() + box.half.sum() + box.centre.norm()))
    {
    }
    double outside(Eigen::Index axis, double side) const { return side * centre[axis] - box.half[axis]; }
    bool is_beyond(Eigen::Index axis, double side) const
    {
        const double out = outside(axis, side);
        if (out + hull.extent() <= needed) return false; // no direction could part them by more
        const Eigen::Vector3d inward = -side * to_box.rotation.row(axis).transpose();
        return out - inward.dot(hull.farthest(inward.cast<float>())) > needed;
    }
};

} // namespace

bool surely_apart(const PartSolids& a, const Eigen::Isometry3d& pose, const PlacedBox& box, double clearance)
{
    const SeenFromBox seen(a, pose, box, clearance);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        if (seen.is_beyond(axis, seen.centre[axis] < 0 ? -1 : 1)) return true;
    return false;
}

bool surely_apart(const PartSolids& a, const Eigen::Isometry3d& begin, const Eigen::Isometry3d& end,
                  const PlacedBox& box, double clearance, double bent)
{
    const SeenFromBox first(a, begin, box, clearance + bent), last(a, end, box, clearance + bent);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double side = first.centre[axis] + last.centre[axis] < 0 ? -1 : 1;
        if (first.is_beyond(axis, side) && last.is_beyond(axis, side)) return true;
    }
    return false;
}

bool surely_meet(const PartSolids& a, const Eigen::Isometry3d& pose, const PlacedBody& body)
{
    const InnerSpheres& inner = a.inner;
    const PlacedBox& box = body.box;
    if (inner.empty()) return false;
    BallFrame frame;
    Eigen::Isometry3d centred = pose;
    centred.translation() = pose * inner.centre();
    set_frame(centred, box.pose, box.centre, frame);
    const double apart = (centred.translation() - box.pose.translation()).cwiseAbs().sum(),
                 size = inner.radius() + apart + box.half.sum() + box.centre.cwiseAbs().sum();
    const Eigen::Vector3d less = body.inside.array() - pose_rounding * size;
    if (!(less.minCoeff() > 0)) return false;
    const float half[3] = {static_cast<float>(less.x()), static_cast<float>(less.y()), static_cast<float>(less.z())};
    const SphereColumns all = inner.columns();
    const bool too_large = box.half.maxCoeff() > inner.radius() * (1 + pose_rounding);
    return ball_kernel().a_ball_meets_box({all.x, all.y, all.z, all.r}, all.count, frame, half, !too_large);
}

} // namespace oncollide
