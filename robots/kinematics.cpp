#include <oncollide/robots/kinematics.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/robots/description_fault.hpp>

namespace oncollide {

namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
    Eigen::Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

/// The x and y axes of a planar joint are the first two columns.
Eigen::Matrix3d tilt_of(const Eigen::Vector3d& axis)
{
    return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
}

} // namespace

std::string_view name_of(JointKind kind)
{
    constexpr std::string_view names[] = {"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
    return names[static_cast<int>(kind)];
}

Kinematics::Kinematics(const RobotDescription& robot)
{
    constexpr std::uint32_t none = 0xffffffffu;
    const std::size_t links = robot.links.size();
    std::vector<std::vector<std::uint32_t>> below(links); // by link: the joints whose parent it is
    std::vector<std::uint8_t> is_child(links);
    for (std::uint32_t i = 0; i < robot.joints.size(); ++i) {
        const RobotJoint& joint = robot.joints[i];
        below[joint.parent].push_back(i), is_child[joint.child] = 1;
        first_.push_back(numbers_of(joint) == 0 ? -1 : static_cast<int>(names_.size()));
        if (joint.kind == JointKind::planar)
            for (const char* part : {"x", "y", "angle"}) names_.push_back(joint.name + "/" + part);
        else if (joint.kind == JointKind::floating)
            for (const char* part : {"x", "y", "z", "qx", "qy", "qz", "qw"}) names_.push_back(joint.name + "/" + part);
        else if (numbers_of(joint) == 1)
            names_.push_back(joint.name);
    }
    root_ = static_cast<std::uint32_t>(std::ranges::find(is_child, 0) - is_child.begin());
    // Breadth first: each round adds the joints below links that were reached.
    std::vector<std::uint32_t> reached{root_};
    for (std::size_t at = 0; at < reached.size(); ++at)
        for (const std::uint32_t i : below[reached[at]]) {
            reached.push_back(robot.joints[i].child);
            steps_.push_back(step_of(robot, i));
        }
    ONCOLLIDE_ASSERT(reached.size() == links);
    step_to_.assign(links, none), depth_.assign(links, 0), below_.resize(links);
    for (const Step& step : steps_) below_[step.parent].push_back(step.child);
    for (std::uint32_t i = 0; i < steps_.size(); ++i)
        step_to_[steps_[i].child] = i, depth_[steps_[i].child] = depth_[steps_[i].parent] + 1;
}

Kinematics::Step Kinematics::step_of(const RobotDescription& robot, std::uint32_t i) const
{
    const RobotJoint& joint = robot.joints[i];
    const bool mimics = joint.mimics >= 0;
    const int first = first_[mimics ? static_cast<std::size_t>(joint.mimics) : i];
    const double length = joint.axis.norm();
    const Eigen::Vector3d axis = std::abs(length - 1) > 1e-12 ? Eigen::Vector3d(joint.axis / length) : joint.axis;
    const Eigen::Matrix3d turn = joint.origin.linear(), k = cross_matrix(axis);
    Step step{joint.parent,
              joint.child,
              joint.kind,
              static_cast<std::uint32_t>(std::max(first, 0)),
              static_cast<std::uint32_t>(numbers_of(robot.joints[mimics ? static_cast<std::size_t>(joint.mimics) : i])),
              mimics ? joint.multiplier : 1,
              mimics ? joint.offset : 0,
              turn,
              Eigen::Matrix3d::Zero(),
              Eigen::Matrix3d::Zero(),
              joint.origin.translation(),
              turn * axis,
              joint.origin,
              axis};
    if (joint.kind == JointKind::revolute || joint.kind == JointKind::continuous) // Rodrigues' formula
        step.constant = turn * (Eigen::Matrix3d::Identity() + k * k), step.by_sine = turn * k,
        step.by_cosine = -turn * k * k;
    return step;
}

void Kinematics::link_poses(const double* numbers, const Eigen::Isometry3d& base, Eigen::Isometry3d* poses) const
{
    poses[root_] = base;
    for (const Step& step : steps_) {
        const Eigen::Isometry3d& parent = poses[step.parent];
        Eigen::Isometry3d& child = poses[step.child];
        child.makeAffine();
        const double value = step.kind == JointKind::fixed ? 0 : numbers[step.number] * step.multiplier + step.offset;
        switch (step.kind) {
        case JointKind::fixed:
            child = parent * step.origin;
            break;
        case JointKind::prismatic:
            child.linear() = parent.linear() * step.constant;
            child.translation() = parent.linear() * (step.translation + value * step.along) + parent.translation();
            break;
        case JointKind::revolute:
        case JointKind::continuous: {
            const Eigen::Matrix3d turn =
                step.constant + std::sin(value) * step.by_sine + std::cos(value) * step.by_cosine;
            child.linear() = parent.linear() * turn;
            child.translation() = parent.linear() * step.translation + parent.translation();
            break;
        }
        case JointKind::planar: { // in the plane across the axis
            Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
            motion.translation() =
                tilt_of(step.axis) * Eigen::Vector3d(numbers[step.number], numbers[step.number + 1], 0);
            motion.linear() = Eigen::AngleAxisd(numbers[step.number + 2], step.axis).toRotationMatrix();
            child = parent * step.origin * motion;
            break;
        }
        case JointKind::floating: {
            const double* n = numbers + step.number;
            Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
            motion.translation() << n[0], n[1], n[2];
            motion.linear() = Eigen::Quaterniond(n[6], n[3], n[4], n[5]).normalized().toRotationMatrix();
            child = parent * step.origin * motion;
            break;
        }
        }
    }
}

namespace {

Eigen::Quaterniond unit(const double* quaternion)
{
    return Eigen::Map<const Eigen::Quaterniond>(quaternion).normalized();
}

} // namespace

std::span<const Kinematics::Twist> Kinematics::twists_of(const Step& step, const double* numbers,
                                                         std::array<Twist, 7>& twists)
{
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    if (step.kind == JointKind::planar) {
        const Eigen::Matrix3d tilt = tilt_of(step.axis);
        twists[0] = {tilt.col(0), zero, zero}, twists[1] = {tilt.col(1), zero, zero},
        twists[2] = {zero, step.axis, zero};
        return std::span(twists).first(3);
    }
    const Eigen::Map<const Eigen::Quaterniond> given(numbers + step.number + 3);
    const double length = given.norm();
    const Eigen::Quaterniond back = given.normalized().conjugate();
    for (int k = 0; k < 3; ++k) twists[static_cast<std::size_t>(k)] = {Eigen::Vector3d::Unit(k), zero, zero};
    for (int k = 0; k < 4; ++k) { // a number's change turns by twice the vector of change * back; its length does not
        Eigen::Quaterniond change;
        change.coeffs() = Eigen::Vector4d::Unit(k);
        twists[static_cast<std::size_t>(3 + k)] = {zero, 2 / length * (change * back).vec(), zero};
    }
    return twists;
}

void Kinematics::between(const double* from, const double* to, double share, double* numbers) const
{
    for (std::size_t i = 0; i < width(); ++i) numbers[i] = std::lerp(from[i], to[i], share); // exact at both ends
    for (const Step& step : steps_)
        if (step.kind == JointKind::floating) {
            const std::size_t q = step.number + 3;
            Eigen::Map<Eigen::Quaterniond>(numbers + q) = unit(from + q).slerp(share, unit(to + q));
        }
}

double BallTravel::off(double arm) const
{
    if (turned > 3) return std::numeric_limits<double>::infinity(); // the shorter arc could be the other one
    // A chord differs from its curve by at most an eighth of the second derivative.
    return helix ? 0 : 0.125 * (bend + turned * turned * arm) * (1 + 1e-12);
}

void Kinematics::rigid_links(const double* from, const double* to, std::vector<std::uint32_t>& highest) const
{
    highest.assign(steps_.size() + 1, root_);
    for (const Step& step : steps_) {
        const bool rests = std::equal(from + step.number, from + step.number + step.width, to + step.number);
        highest[step.child] = rests ? highest[step.parent] : step.child;
    }
}

BallTravel Kinematics::travel(const double* from, const double* to, double half, const Eigen::Isometry3d* poses,
                              const CoverSphere& ball, std::uint32_t link, std::uint32_t seen_from) const
{
    const Eigen::Vector3d centre = poses[link] * ball.centre;
    BallTravel all; // seen from the link that the walk has reached
    int moving = 0;
    const auto shift = [&](double length) { all.moved += half * length, all.speed += 2 * half * length; };
    const auto turn = [&](double angle, double distance) { // around the axis or the origin
        const double a = 2 * half * std::abs(angle), reach = distance + ball.radius + all.moved;
        all.bend += 2 * a * all.speed + a * a * reach; // Coriolis and centripetal
        all.speed += a * reach, all.turned += a;
        all.moved += std::min(0.5 * a, 2.0) * reach; // a chord
    };
    const auto pass = [&](std::uint32_t child) { // the joint above the child, in either direction
        const Step& step = steps_[step_to_[child]];
        if (step.kind == JointKind::fixed) return;
        const double *const a = from + step.number, *const b = to + step.number;
        const Eigen::Vector3d arm = centre - poses[child].translation();
        const auto from_axis = [&] { return arm.cross(poses[child].linear() * step.axis).norm(); };
        const double speed_before = all.speed;
        switch (step.kind) {
        case JointKind::fixed:
            break;
        case JointKind::prismatic:
            shift(std::abs(step.multiplier * (b[0] - a[0])));
            break;
        case JointKind::revolute:
        case JointKind::continuous:
            if (a[0] != b[0]) turn(step.multiplier * (b[0] - a[0]), from_axis());
            break;
        // Seen from the child, a shift also turns points; in the other direction this bound is larger than needed.
        case JointKind::planar:
            shift(std::hypot(b[0] - a[0], b[1] - a[1]));
            turn(b[2] - a[2], from_axis());
            break;
        case JointKind::floating: {
            shift((Eigen::Map<const Eigen::Vector3d>(b) - Eigen::Map<const Eigen::Vector3d>(a)).norm());
            turn(unit(a + 3).angularDistance(unit(b + 3)), arm.norm());
            break;
        }
        }
        if (all.speed > speed_before)
            ++moving, all.helix = all.helix && moving == 1 && step.kind != JointKind::planar &&
                                  step.kind != JointKind::floating;
    };
    const std::uint32_t top = common(link, seen_from);
    for (; link != top; link = parent(link)) pass(link);
    const auto descend = [&](auto& self, std::uint32_t to_link) -> void {
        if (to_link == top) return;
        self(self, parent(to_link));
        pass(to_link);
    };
    descend(descend, seen_from);
    all.moved *= 1 + 1e-12;
    return all;
}

std::uint32_t Kinematics::common(std::uint32_t a, std::uint32_t b) const
{
    while (a != b) {
        std::uint32_t& lower = depth_[a] < depth_[b] ? b : a;
        lower = parent(lower);
    }
    return a;
}

bool Kinematics::numbers_between(std::uint32_t a, std::uint32_t b, std::vector<Acting>& numbers) const
{
    numbers.clear();
    const std::uint32_t top = common(a, b);
    for (std::uint32_t end : {a, b})
        for (std::uint32_t link = end; link != top; link = parent(link)) {
            const Step& step = steps_[step_to_[link]];
            if (step.kind == JointKind::fixed) continue;
            if (step.kind == JointKind::planar || step.kind == JointKind::floating) return false;
            const bool turns = step.kind != JointKind::prismatic && std::abs(step.multiplier) == 1;
            const auto known = std::ranges::find(numbers, step.number, &Acting::number);
            if (known == numbers.end())
                numbers.push_back({step.number, turns});
            else
                known->turns = known->turns && turns;
        }
    std::ranges::sort(numbers, {}, &Acting::number);
    return true;
}

std::vector<std::uint32_t> Kinematics::links_between(std::uint32_t a, std::uint32_t b) const
{
    const std::uint32_t top = common(a, b);
    std::vector<std::uint32_t> links;
    for (; a != top; a = parent(a)) links.push_back(a);
    for (; b != top; b = parent(b)) links.push_back(b);
    links.push_back(top);
    return links;
}

void Kinematics::ways_from(std::uint32_t link, std::vector<Way>& ways) const
{
    ways.resize(step_to_.size());
    struct Visit {
        std::uint32_t link, from, steps;
    };
    std::vector<Visit> open{{link, link, 0}};
    std::vector<std::uint32_t> path; // from `link` to the link that is visited
    while (!open.empty()) {          // depth first, so that the path is at hand
        const Visit next = open.back();
        open.pop_back();
        path.resize(next.steps), path.push_back(next.link);
        ways[next.link] = {next.steps + 1, path[(next.steps + 1) / 2]};
        const auto visit = [&](std::uint32_t to) {
            if (to != next.from) open.push_back({to, next.link, next.steps + 1});
        };
        if (next.link != root_) visit(parent(next.link));
        for (const std::uint32_t child : below_[next.link]) visit(child);
    }
}

} // namespace oncollide
