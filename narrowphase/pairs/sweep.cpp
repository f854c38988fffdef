#include <oncollide/narrowphase/pairs/sweep.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include <oncollide/narrowphase/pairs/containment.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>

namespace oncollide {

namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
constexpr double no_bound = std::numeric_limits<double>::infinity();

MovingBody moving_body(Model& model, const RigidMotion& motion, double time)
{
    const RigidMotion::State state = motion.at(time);
    if (model.kind() == Kind::half_space) return {model, state, state.pose.translation(), 0};
    const Aabb box = bounds_of(model.geometry());
    return {model, state, state.pose * box.centre(), box.half_extent().norm() * (1 + 0x1p-18)};
}

/// The motion of a half-space counts where the other body is.
bool is_plane(const MovingBody& body)
{
    return body.model.kind() == Kind::half_space;
}

/// How far the body may be from its linear motion over half a window of duration 2 * half, besides rotation about a
/// point of it: the centrifugal acceleration, and the error of its poses.
double bend(const MovingBody& body, double half)
{
    const double angle = half * body.state.angular.norm();
    double off = 2 * body.state.position_error;
    if (angle > 0) {
        const Vector3d arm = body.centre - body.state.pivot;
        const double off_axis = body.state.angular.cross(arm).norm() / body.state.angular.norm() + body.radius;
        off += 0.5 * angle * angle * off_axis;
    }
    if (body.state.rotation_error > 0)
        off += 2 * body.state.rotation_error * (body.radius + (body.centre - body.state.pose.translation()).norm());
    return off * (1 + 0x1p-20);
}

/// The number with the fewest binary digits between two times.
double simplest_between(double low, double high)
{
    for (double step = 1; step > 0x1p-60; step *= 0.5)
        if (const double time = std::ceil(low / step) * step; time <= high) return time;
    return high;
}

} // namespace

MotionWindow::MotionWindow(const SweepTask& task, double begin, double end)
    : task_(task), begin_(begin), end_(end), a_(moving_body(*task.a, *task.motion_a, 0.5 * (begin + end))),
      b_(moving_body(*task.b, *task.motion_b, 0.5 * (begin + end)))
{
}

SweptMotion MotionWindow::motion(bool swap) const
{
    const MovingBody &first = swap ? b_ : a_, &second = swap ? a_ : b_;
    const double half = 0.5 * (end_ - begin_);
    const Eigen::Matrix3d into = first.state.pose.linear().transpose();
    const Vector3d origin = first.state.pose.translation();
    const auto side = [&](const RigidMotion::State& state) {
        const Vector3d at_origin = state.velocity + state.angular.cross(origin - state.pivot);
        return SweptSide{half * (into * at_origin), half * (into * state.angular)};
    };
    SweptMotion motion{side(first.state), side(second.state), task_.clearance + bend(a_, half) + bend(b_, half)};
    // In poses that are not quite rigid, motions turn by slightly other angles.
    const double stretched = stretch(first.state.pose) + stretch(second.state.pose);
    const double turned = half * ((first.state.angular.norm() + second.state.angular.norm()) *
                                  (first.radius + second.radius + (first.centre - second.centre).norm()));
    const double far = a_.centre.norm() + b_.centre.norm() + a_.radius + b_.radius;
    motion.slack += 2 * stretched * (turned + half * (first.state.velocity - second.state.velocity).norm());
    motion.slack += 0x1p-48 * (far + motion.a.shift.norm() + motion.b.shift.norm());
    return motion;
}

namespace {

/// The time until which both bodies move as they do at a time.
double next_key(const SweepTask& task, double now)
{
    return std::min({1.0, task.motion_a->at(now).key, task.motion_b->at(now).key});
}

class Sweep {
public:
    Sweep(PairWorker& worker, const SweepTask& task, FindEntry entry, FindContact contact)
        : worker_(worker), task_(task), tests_(tests_for(task.a->kind(), task.b->kind())), entry_(entry),
          contact_(contact)
    {
        const auto off = [](const Model& model) { return model.terrain() ? model.terrain()->error() : 0; };
        inexact_ = task.clearance > 0 || off(*task.a) + off(*task.b) > 0;
    }

    SweepResult run()
    {
        const bool window_first = task_.begins_apart && !may_hold();
        if (!window_first && begins_in_contact(task_.memory ? *task_.memory : PairMemory())) return result_;
        width_ = widest();
        for (; result_.steps < task_.options.most_steps; ++result_.steps) {
            if (result_.clear_until >= task_.until) {
                result_.verdict = Verdict::separate, result_.normal.setZero();
                return result_;
            }
            if (step(window_first && result_.steps == 0)) return result_;
        }
        return result_;
    }

private:
    static constexpr double least_width = 0x1p-46;
    static constexpr double most_turn = 0.25; ///< rad, of both bodies in one window

    double next_key() const { return oncollide::next_key(task_, result_.clear_until); }
    /// Wider windows cost more than they gain: the motion in them is less linear.
    double widest() const
    {
        const double now = result_.clear_until;
        const double spin = task_.motion_a->at(now).angular.norm() + task_.motion_b->at(now).angular.norm();
        return spin > most_turn ? most_turn / spin : 1;
    }

    /// The time in which the bodies approach each other by no more than the tolerances.
    double tolerance_in(const MotionWindow& window) const
    {
        const MovingBody &a = window.body(true), &b = window.body(false);
        const auto speed = [](const RigidMotion::State& state, const MovingBody& where) {
            return state.velocity.norm() + state.angular.cross(where.centre - state.pivot).norm() +
                   state.angular.norm() * where.radius;
        };
        const double speeds =
            (speed(a.state, is_plane(a) ? b : a) + speed(b.state, is_plane(b) ? a : b)) * (1 + 0x1p-16);
        return std::min({task_.options.time_tolerance, task_.options.gap_tolerance / speeds, 1.0});
    }

    /// True if one body may enclose the other while their surfaces, which windows compare, are apart.
    bool may_hold() const
    {
        const auto parts = [](Kind kind) { return kind == Kind::mesh || kind == Kind::terrain || kind == Kind::map; };
        const Kind a = task_.a->kind(), b = task_.b->kind();
        return task_.solid || (a == Kind::polytope && parts(b)) || (b == Kind::polytope && parts(a));
    }
    /// @param hints  of time 0; without contact, memory_ stays as it is
    bool begins_in_contact(PairMemory hints)
    {
        std::swap(memory_, hints);
        hinted_ = task_.parts_by_poses && (memory_.met || memory_.place.index() > 0);
        if (!meets_at(0)) {
            memory_ = hints, hinted_ = false;
            return false;
        }
        if (task_.memory) task_.memory->take_witness(memory_);
        set_contact(0);
        const double soon = tolerance_in(MotionWindow(task_, 0, 0));
        result_.separating = decide(soon).verdict == Verdict::separate;
        return true;
    }
    /// Examines the next window. Returns true if the result is final.
    /// @param first  the poses at time 0 are not decided yet
    bool step(bool first)
    {
        const double begin = result_.clear_until, end = std::min(begin + width_, next_key());
        const MotionWindow window(task_, begin, end);
        const PartsEntry entry = entry_(window, memory_);
        if (first && entry.time <= -1 && begins_in_contact(memory_)) return true;
        if (entry.time > 1) {
            result_.clear_until = end;
            width_ = std::min(2 * (end - begin), widest());
            return false;
        }
        if (!entry.direction.isZero(0)) result_.normal = entry.direction;
        const double now = std::max(begin, std::min(window.time(entry.time) * (1 - 0x1p-52), end));
        const double likely = entry.likely < after_window ? window.time(entry.likely) : end;
        result_.clear_until = now;
        tolerance_ = tolerance_in(window);
        const bool moved_on = now > begin;
        if (likely - now <= 0.5 * tolerance_ || end - begin <= tolerance_) {
            if (try_contact(now, end, moved_on)) return true;
        }
        const double rest = end - now;
        width_ = std::clamp(2 * (likely - now), 0x1p-4 * rest, 0.5 * (end - begin));
        if (!(width_ > least_width)) return leave_open();
        return false;
    }
    /// Looks for a contact soon after `now`.
    bool try_contact(double now, double end, bool moved_on)
    {
        const double soon = std::min(now + tolerance_, next_key()); // after a key, the bodies may be faster
        if ((moved_on || soon != tried_) && meets_at(tried_ = soon)) return set_contact(soon), true;
        if (end < soon && meets_at(end)) return set_contact(end), true;
        if (end - now > tolerance_) return false;
        const double simple = simplest_between(now, end);
        if (simple != end && simple != soon && meets_at(simple)) return set_contact(simple), true;
        return false;
    }
    /// Rounding hides whether the bodies meet.
    bool leave_open()
    {
        const double time = result_.clear_until;
        place(time);
        const Distance d = tests_.distance(worker_, at_, 0, no_bound, task_.solid);
        result_.verdict = Verdict::within, result_.contact_by = time, result_.gap = d.upper;
        result_.contact = {d.a, d.b, ContactKind::near, {d.point_a, d.point_b}, Vector3d::Zero(), Vector3d::Zero()};
        return true;
    }

    /// Upper bound of how much the distance changes until `end`, where it is at most found_.bound.
    double distance_moved(double begin, double end) const
    {
        const MovingBody a = moving_body(*task_.a, *task_.motion_a, begin),
                         b = moving_body(*task_.b, *task_.motion_b, begin);
        // Two half-spaces meet far away as soon as one rotates, from any distance.
        if (is_plane(a) && is_plane(b) && !(a.state.angular.isZero(0) && b.state.angular.isZero(0))) return no_bound;
        const auto travel = [&](const RigidMotion& motion, const MovingBody& body, const Vector3d& centre,
                                double radius) {
            if (motion.rests()) return 0.0;
            return motion.travel(begin, end, body.state.pose.inverse(Eigen::Isometry) * centre, radius);
        };
        double of_a = is_plane(a) ? 0 : travel(*task_.motion_a, a, a.centre, a.radius);
        double of_b = is_plane(b) ? 0 : travel(*task_.motion_b, b, b.centre, b.radius);
        if (is_plane(a)) of_a = travel(*task_.motion_a, a, b.centre, b.radius + of_b + found_.bound);
        if (is_plane(b)) of_b = travel(*task_.motion_b, b, a.centre, a.radius + of_a + found_.bound);
        return of_a + of_b;
    }
    void place(double time)
    {
        pose_a_ = task_.motion_a->pose(time), pose_b_ = task_.motion_b->pose(time);
        at_ = {0, task_.a, task_.b, &pose_a_, &pose_b_};
    }
    Finding decide(double time)
    {
        place(time);
        found_ = tests_.decide(worker_, at_, {.clearance = task_.clearance}, &memory_);
        if (time == 0 && task_.solid && found_.verdict == Verdict::separate) {
            const auto around = [](const Model& model) { return model.has_inside() ? model.obb_tree() : nullptr; };
            if (one_holds_the_other(at_, worker_.locator, around))
                found_ = {Verdict::colliding, ContactKind::enclosed, 0};
        }
        return found_;
    }
    /// True if the bodies certainly meet, or come within the clearance, at this time. At the ends of the motion,
    /// undecided poses count, too.
    bool meets_at(double time)
    {
        const Finding found = decide(time);
        return found.verdict == Verdict::colliding || found.kind == ContactKind::near ||
               (found.verdict == Verdict::within && (time == 0 || time == 1 || inexact_));
    }
    /// Sets the contact of the last decision.
    void set_contact(double time)
    {
        result_.verdict = found_.verdict, result_.kind = found_.kind;
        result_.contact_by = time;
        result_.gap = time > 0 ? found_.bound + distance_moved(result_.clear_until, time) : found_.bound;
        if (time == 0) result_.normal.setZero();
        if (found_.kind == ContactKind::enclosed) return;
        if (found_.verdict == Verdict::colliding) {
            auto contact = contact_(at_, memory_);
            if (contact && hinted_) {
                PairMemory none;
                tests_.decide(worker_, at_, {.clearance = task_.clearance}, &none);
                contact = contact_(at_, none);
            }
            if (contact) {
                result_.contact = *contact;
                return;
            }
            worker_.meetings.clear();
            tests_.contacts(worker_, at_, worker_.meetings);
            if (!worker_.meetings.empty()) result_.contact = worker_.meetings.front();
        } else {
            const Distance d = tests_.distance(worker_, at_, 0, no_bound, false);
            result_.contact = {d.a, d.b, ContactKind::near, {d.point_a, d.point_b}, Vector3d::Zero(), Vector3d::Zero()};
        }
    }

    PairWorker& worker_;
    const SweepTask& task_;
    const PairTests& tests_;
    FindEntry entry_;
    FindContact contact_;
    SweepResult result_;
    PairMemory memory_;
    double tolerance_ = 1, width_ = 1, tried_ = -1;
    bool hinted_ = false; ///< the last decision had hints, on which the parts must not depend
    bool inexact_;        ///< bodies within an error or the clearance are in contact
    Isometry3d pose_a_, pose_b_;
    PairTask at_{};
    Finding found_;
};

/// A lower bound of the time of contact: of the first window in which the bodies may meet.
SweepResult bound_of(const SweepTask& task, FindEntry entry)
{
    SweepResult found;
    PairMemory memory;
    while (found.clear_until < 1) {
        const double begin = found.clear_until;
        const double end = next_key(task, begin);
        const MotionWindow window(task, begin, end);
        const PartsEntry first = entry(window, memory);
        found.clear_until = first.time > 1 ? end : std::clamp(window.time(first.time) * (1 - 0x1p-52), begin, end);
        if (first.time <= 1) return found;
    }
    found.verdict = Verdict::separate;
    return found;
}

} // namespace

SweepResult sweep(PairWorker& worker, const SweepTask& task, FindEntry entry, FindContact contact)
{
    if (task.bound_only) return bound_of(task, entry);
    return Sweep(worker, task, entry, contact).run();
}

} // namespace oncollide
