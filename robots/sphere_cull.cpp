#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/numbers/infinity.hpp>

namespace oncollide {

SphereCull::SphereCull(const Robot::Impl& robot, double clearance)
    : robot_(robot), clearance_(clearance), stretch_(robot.stretch()), groups_(robot.groups.size()),
      spheres_(robot.spheres.size() + robot.parts.size()), placed_(robot.parts.size())
{
}

SphereCull::Placed SphereCull::placed(const CoverSphere& sphere, std::uint32_t link) const
{
    const Eigen::Vector3d at = links_[link] * sphere.centre;
    const double slack = 1e-12 * (links_[link].translation().cwiseAbs().sum() + sphere.centre.cwiseAbs().sum());
    return {at.x(), at.y(), at.z(), sphere.radius * stretch_ + slack};
}

void SphereCull::place(const Eigen::Isometry3d* links)
{
    links_ = links;
    std::ranges::fill(placed_, std::uint8_t{0});
    for (std::size_t i = 0; i < groups_.size(); ++i) groups_[i] = placed(robot_.groups[i].whole, robot_.groups[i].link);
}

const SphereCull::Placed* SphereCull::spheres_of(std::uint32_t i)
{
    const Robot::Impl::Part& part = robot_.parts[i];
    Placed* const first = &spheres_[part.cover.first + i];
    if (!placed_[i]) {
        first[0] = placed(part.cover.whole, part.link);
        for (std::uint32_t k = 0; k < part.cover.count; ++k)
            first[k + 1] = placed(robot_.spheres[part.cover.first + k], part.link);
        placed_[i] = 1;
    }
    return first;
}

bool SphereCull::meet(const Placed& a, const Placed& b, double reach) const
{
    const double dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
    const double within = (a.radius + b.radius + clearance_ + reach) * (1 + 1e-12);
    return dx * dx + dy * dy + dz * dz <= within * within;
}

double SphereCull::gap(const Placed& a, const Placed& b)
{
    const double dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
    return std::max(std::sqrt(dx * dx + dy * dy + dz * dz) * (1 - 1e-12) - (a.radius + b.radius), 0.0);
}

double SphereCull::gap_of_parts(std::uint32_t a, std::uint32_t b)
{
    const Placed *const of_a = spheres_of(a), *const of_b = spheres_of(b);
    const std::uint32_t count_a = robot_.parts[a].cover.count, count_b = robot_.parts[b].cover.count;
    double least = infinity;
    for (std::uint32_t i = 1; i <= count_a && least > 0; ++i) {
        if (gap(of_a[i], of_b[0]) >= least) continue;
        for (std::uint32_t k = 1; k <= count_b; ++k) least = std::min(least, gap(of_a[i], of_b[k]));
    }
    return std::max(least, gap(of_a[0], of_b[0]));
}

double SphereCull::gap_of_group(std::uint32_t a, const Aabb& box) const
{
    const Placed& ball = groups_[a];
    const Eigen::Vector3d at(ball.x, ball.y, ball.z);
    return std::max((box.min - at).cwiseMax(at - box.max).cwiseMax(0).norm() * (1 - 1e-12) - ball.radius, 0.0);
}

Aabb SphereCull::box_of_group(std::uint32_t a) const
{
    const Placed& ball = groups_[a];
    const Eigen::Vector3d at(ball.x, ball.y, ball.z);
    return {at.array() - ball.radius, at.array() + ball.radius};
}

double SphereCull::gap_of_part(std::uint32_t a, const PlacedBox& box)
{
    const Placed* const balls = spheres_of(a);
    const Eigen::Matrix3d into = box.pose.linear().transpose();
    const Eigen::Vector3d middle = into * box.pose.translation() + box.centre;
    const auto gap_of = [&](const Placed& ball) {
        const Eigen::Vector3d at(ball.x, ball.y, ball.z), p = into * at - middle;
        const double slack = 1e-12 * (at.cwiseAbs().sum() + middle.cwiseAbs().sum() + box.half.sum());
        return std::max(((p.cwiseAbs() - box.half).cwiseMax(0).norm() - slack) / stretch_ - ball.radius, 0.0);
    };
    double least = infinity;
    for (std::uint32_t i = 1; i <= robot_.parts[a].cover.count && least > 0; ++i)
        least = std::min(least, gap_of(balls[i]));
    return std::max(least, gap_of(balls[0]));
}

bool SphereCull::near(std::uint32_t a, std::uint32_t b, double reach)
{
    const Placed *const of_a = spheres_of(a), *const of_b = spheres_of(b);
    if (!meet(of_a[0], of_b[0], reach)) return false;
    const std::uint32_t count_a = robot_.parts[a].cover.count, count_b = robot_.parts[b].cover.count;
    for (std::uint32_t i = 1; i <= count_a; ++i) {
        if (!meet(of_a[i], of_b[0], reach)) continue;
        for (std::uint32_t k = 1; k <= count_b; ++k)
            if (meet(of_a[i], of_b[k], reach)) return true;
    }
    return false;
}

} // namespace oncollide
