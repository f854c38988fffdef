#include <oncollide/robots/edges/edge_cull.hpp>

#include <algorithm>

namespace oncollide {

namespace {

double size_of(const OuterHull& hull)
{
    return hull.centre().norm() + hull.extent();
}

} // namespace

EdgeCull::EdgeCull(const Robot::Impl& robot, const World& world, const Clearances& clearances, EdgeMotion& motion)
    : robot_(robot), clearances_(clearances), rounding_(robot.rounding()), motion_(motion), tests_(world),
      bodies_(tests_)
{
    tests_.begin();
}

void EdgeCull::start()
{
    across_.assign(robot_.parts.size() * robot_.parts.size(), Eigen::Vector3d::Zero());
}

bool EdgeCull::is_open(std::uint32_t part, std::uint32_t number, double begin, double end, double bent)
{
    const Robot::Impl::Part& of = robot_.parts[part];
    const PlacedBox& box = bodies_[number].box;
    const BodyId body = tests_.body_at(bodies_[number].slot);
    if (robot_.allows(of.link, body)) return false;
    const double clearance = clearances_.of_body(of.link, body);
    const Eigen::Isometry3d *const first = motion_.at(begin).links.data(), *const last = motion_.at(end).links.data();
    // The middle of the part's ball moves along a chord.
    const CoverSphere& ball = of.cover.whole;
    const Eigen::Vector3d a = first[of.link] * ball.centre, b = last[of.link] * ball.centre, middle = 0.5 * (a + b);
    const Eigen::Vector3d seen = box.pose.linear().transpose() * (middle - box.pose.translation()) - box.centre;
    const double size = seen.cwiseAbs().sum() + ball.radius + box.half.sum() + box.centre.norm();
    const double within =
        0.5 * (b - a).norm() + ball.radius + bent + clearance + rounding_ * size + 1e-12 * middle.norm();
    if ((seen.cwiseAbs() - box.half).cwiseMax(0).squaredNorm() > within * within) return false;
    return !of.solids || !surely_apart(*of.solids, robot_.pose_of(of, first), robot_.pose_of(of, last), box, clearance,
                                       bent + rounding_ * size);
}

bool EdgeCull::is_open(const EdgeItem& item, const EdgeWays& ways)
{
    const double bent = (ways.a.sagitta() + ways.b.sagitta()) * robot_.stretch();
    if (item.b == no_part) return is_open(item.a, item.box, item.begin, item.end, bent);
    const Robot::Impl::Part &a = robot_.parts[item.a], &b = robot_.parts[item.b];
    if (!a.solids || !b.solids) return true;
    const Eigen::Isometry3d *const first = motion_.at(item.begin).links.data(),
                                   *const last = motion_.at(item.end).links.data(),
                                   *const links = motion_.middle().links.data();
    struct Seen {
        RelativePose b_to_a;
        Eigen::Matrix3d direction; ///< turns directions from the frame of the item's link into a's frame
    };
    const auto seen = [&](const Eigen::Isometry3d* at) {
        const Eigen::Isometry3d of_a = robot_.pose_of(a, at);
        return Seen{RelativePose(of_a, robot_.pose_of(b, at)), of_a.linear().transpose() * at[item.seen_from].linear()};
    };
    const Seen begin = seen(first), end = seen(last);
    const double size = begin.b_to_a.translation.norm() + end.b_to_a.translation.norm() + size_of(a.solids->hull) +
                        size_of(b.solids->hull);
    const double clearance = clearances_.of_links(a.link, b.link), needed = clearance + rounding_ * (size + clearance);
    const auto parts = [&](const Eigen::Vector3d& across) {
        return gap_along(a.solids->hull, b.solids->hull, begin.b_to_a, begin.direction * across) > needed + bent &&
               gap_along(a.solids->hull, b.solids->hull, end.b_to_a, end.direction * across) > needed + bent;
    };
    Eigen::Vector3d& across = across_[item.a * robot_.parts.size() + item.b];
    if (!across.isZero(0) && parts(across)) return false;
    const Seen middle = seen(links);
    const Eigen::Vector3f guess = (middle.direction * across).cast<float>();
    const double enough = needed + motion_.reach(ways);
    const HullGap gap = hull_gap(a.solids->hull, b.solids->hull, middle.b_to_a, guess, enough);
    if (gap.gap <= 0) return true;
    across = (middle.direction.transpose() * gap.across.cast<double>()).normalized();
    return gap.gap <= enough && !parts(across);
}

} // namespace oncollide
