#include <oncollide/scenes/motion.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

namespace {

using Eigen::Isometry3d;

Isometry3d rigid(const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation)
{
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = rotation;
    pose.translation() = position;
    return pose;
}

/// x after reflections between the walls lo and hi: a triangle wave of period 2 (hi - lo). Exactly x between them.
double reflected(double x, double lo, double hi)
{
    if (x >= lo && x <= hi) return x;
    const double width = hi - lo;
    if (width <= 0) return lo;
    double phase = std::fmod(x - lo, 2 * width);
    if (phase < 0) phase += 2 * width;
    return std::clamp(phase <= width ? lo + phase : hi - (phase - width), lo, hi);
}

void check_numbers(const std::string& name, std::string_view what, const Eigen::Vector3d& v)
{
    constexpr double most = 1e15;
    if (!(v.cwiseAbs().maxCoeff() <= most) || !v.allFinite())
        refuse(name, fmt::format("{} ({}, {}, {}): numbers must be finite and at most {} in size", what, v.x(), v.y(),
                                 v.z(), most));
}

void check_walls(const std::string& name, const Aabb& walls)
{
    if (walls.empty()) return;
    check_numbers(name, "walls", walls.min);
    check_numbers(name, "walls", walls.max);
}

void check(const std::string&, const Still&) {}

void check(const std::string& name, const Drift& motion)
{
    check_numbers(name, "velocity", motion.velocity);
    check_numbers(name, "spin", motion.spin);
    check_walls(name, motion.walls);
}

void check(const std::string& name, const Jitter& motion)
{
    check_numbers(name, "step", {motion.step, 0, 0});
    if (motion.step < 0) refuse(name, fmt::format("step {}: must not be negative", motion.step));
    check_walls(name, motion.walls);
}

void check(const std::string& name, const Keyed& motion)
{
    if (motion.keys.empty()) refuse(name, "the motion has no key; give at least one");
    for (std::size_t i = 0; i < motion.keys.size(); ++i) {
        const Keyed::Key& key = motion.keys[i];
        check_numbers(name, fmt::format("key {}: time", i), {key.time, 0, 0});
        check_numbers(name, fmt::format("key {}: position", i), key.position);
        if (i > 0 && !(motion.keys[i - 1].time < key.time))
            refuse(name, fmt::format("key {}: time {} does not come after the time before it, {}", i, key.time,
                                     motion.keys[i - 1].time));
        if (!(std::abs(key.rotation.norm() - 1) <= 1e-6))
            refuse(name, fmt::format("key {}: the quaternion's length is {}, it must be 1", i, key.rotation.norm()));
    }
}

Isometry3d pose_of(const Keyed::Key& key)
{
    return rigid(key.position, key.rotation.normalized().toRotationMatrix());
}

Isometry3d pose_at(const Still&, const Isometry3d& start, double)
{
    return start;
}

Isometry3d pose_at(const Jitter&, const Isometry3d& start, double)
{
    return start;
}

Isometry3d pose_at(const Keyed& motion, const Isometry3d& start, double time)
{
    if (motion.keys.empty()) return start;
    const auto next = std::upper_bound(motion.keys.begin(), motion.keys.end(), time,
                                       [](double t, const Keyed::Key& key) { return t < key.time; });
    if (next == motion.keys.begin()) return pose_of(motion.keys.front());
    const Keyed::Key& from = *std::prev(next);
    if (next == motion.keys.end() || time == from.time) return pose_of(from);
    const double share = (time - from.time) / (next->time - from.time);
    // Eigen's slerp takes the shorter arc; normalised() keeps the matrix rigid to the last bits.
    return rigid(from.position + share * (next->position - from.position),
                 from.rotation.slerp(share, next->rotation).normalized().toRotationMatrix());
}

Isometry3d pose_at(const Drift& motion, const Isometry3d& start, double time)
{
    Eigen::Vector3d position = start.translation() + time * motion.velocity;
    if (!motion.walls.empty())
        for (int axis = 0; axis < 3; ++axis)
            position[axis] = reflected(position[axis], motion.walls.min[axis], motion.walls.max[axis]);
    const double rate = motion.spin.norm();
    if (rate == 0) return rigid(position, start.linear());
    return rigid(position, Eigen::AngleAxisd(time * rate, motion.spin / rate).toRotationMatrix() * start.linear());
}

/// True if a change of the last bits may choose the other arc.
bool nearly_half_a_turn(const Keyed::Key& a, const Keyed::Key& b)
{
    return std::abs(a.rotation.dot(b.rotation)) < 0x1p-10;
}

} // namespace

void move_body(const Motion& motion, const Eigen::Isometry3d& start, double pace, int from, int to,
               Eigen::Isometry3d& pose)
{
    const Jitter* jitter = std::get_if<Jitter>(&motion);
    if (!jitter) {
        pose = pose_at(motion, start, to * pace);
        return;
    }
    Jitter paced = *jitter;
    paced.step *= pace;
    Eigen::Vector3d position = pose.translation();
    for (int f = from + 1; f <= to; ++f) jitter_step(paced, static_cast<std::uint64_t>(f), position);
    pose.translation() = position;
}

std::vector<RigidMotion::Key> way_between(const Motion& motion, double from, double to, const Isometry3d& first,
                                          const Isometry3d& last)
{
    std::vector<RigidMotion::Key> way{{0, first}};
    const auto add = [&](double time, const Isometry3d& pose) {
        if (from < time && time < to) way.push_back({(time - from) / (to - from), pose});
    };
    static const Keyed none;
    const Keyed* const of_keys = std::get_if<Keyed>(&motion);
    const std::vector<Keyed::Key>& keys = (of_keys ? *of_keys : none).keys;
    for (auto key = std::ranges::upper_bound(keys, from, {}, &Keyed::Key::time); key != keys.end(); ++key) {
        if (key != keys.begin() && nearly_half_a_turn(key[-1], *key)) {
            const double middle = key[-1].time + 0.5 * (key->time - key[-1].time);
            add(middle, pose_at(motion, first, middle));
        }
        add(key->time, pose_of(*key));
        if (key->time >= to) break;
    }
    way.push_back({1, last});
    // Shares of times that differ by rounding alone may be equal.
    for (std::size_t i = 1; i + 1 < way.size(); ++i)
        way[i].time = std::max(way[i].time, std::nextafter(way[i - 1].time, 2));
    for (std::size_t i = way.size() - 1; i-- > 1;)
        way[i].time = std::min(way[i].time, std::nextafter(way[i + 1].time, 0));
    const auto stays = [&](const RigidMotion::Key& key) { return key.pose.matrix() == first.matrix(); };
    if (std::ranges::all_of(way, stays)) way.clear();
    return way;
}

void check_motion(const std::string& name, const Motion& motion)
{
    std::visit([&](const auto& m) { check(name, m); }, motion);
}

void jitter_step(const Jitter& motion, std::uint64_t frame, Eigen::Vector3d& position)
{
    for (int axis = 0; axis < 3; ++axis) {
        double& p = position[axis];
        p += motion.step * (u01(motion.seed + frame, motion.index, static_cast<std::uint64_t>(axis)) - 0.5);
        if (motion.walls.empty()) continue;
        const double lo = motion.walls.min[axis], hi = motion.walls.max[axis];
        if (p < lo) p = 2 * lo - p;
        if (p > hi) p = 2 * hi - p;
        p = std::clamp(p, lo, hi); // a step longer than the room could end behind the opposite wall
    }
}

Isometry3d pose_at(const Motion& motion, const Isometry3d& start, double time)
{
    return std::visit([&](const auto& m) { return pose_at(m, start, time); }, motion);
}

} // namespace oncollide
