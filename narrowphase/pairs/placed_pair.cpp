#include <oncollide/narrowphase/pairs/placed_pair.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/narrowphase/model.hpp>

namespace oncollide {

double stretch(const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3d x = pose.linear().col(0), y = pose.linear().col(1), z = pose.linear().col(2);
    const double lengths = std::max({std::abs(x.dot(x) - 1), std::abs(y.dot(y) - 1), std::abs(z.dot(z) - 1)});
    const double angles = std::max({std::abs(x.dot(y)), std::abs(y.dot(z)), std::abs(z.dot(x))});
    if (lengths == 0 && angles == 0 && (pose.linear().array().square() == pose.linear().array().abs()).all()) return 0;
    return 3 * std::max(lengths, angles) + 0x1p-50;
}

double rounding_of(const PairTask& task)
{
    const double rounding = 0x1p-30 + 4 * slack_of(task);
    return rounding * (task.a->reach() + task.b->reach());
}

double surely_separate(const PairTask& task, double beyond)
{
    return beyond * (1 + 0x1p-16) + rounding_of(task);
}

bool decides_b_first(const PairTask& task)
{
    // Bodies at one pose have one frame.
    const auto before = [](const Eigen::Isometry3d& x, const Eigen::Isometry3d& y) {
        return std::lexicographical_compare(x.data(), x.data() + 16, y.data(), y.data() + 16);
    };
    if (before(*task.pose_b, *task.pose_a)) return true;
    return !before(*task.pose_a, *task.pose_b) && task.b->kind() < task.a->kind();
}

PlacedPair::PlacedPair(const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b)
    : PlacedPair(pose_a, pose_b, stretch(pose_a) + stretch(pose_b))
{
}

PlacedPair::PlacedPair(const PairTask& task) : PlacedPair(*task.pose_a, *task.pose_b, slack_of(task)) {}

} // namespace oncollide
