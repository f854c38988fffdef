#include <oncollide/narrowphase/pairs/sweep.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include <oncollide/narrowphase/pairs/containment.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>

namespace oncollide {

namespace {

using Eigen::Isometry3d, Eigen::Vector3d;
constexpr double no_bound = std::numeric_limits<double>::infinity();

/// The number with the fewest binary digits between two times.
double simplest_between(double low, double high)
{
    for (double step = 1; step > 0x1p-60; step *= 0.5)
        if (const double time = std::ceil(low / step) * step; time <= high) return time;
    return high;
}

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
        if (!window_first && begins_in_contact(task_.memory ? *task_.memory : PairMemory()) && ends_at_begin())
            return result_;
        if (!grazes_) width_ = widest();
        for (; result_.steps < task_.options.most_steps; ++result_.steps) {
            if (now_ >= task_.until) {
                end_without_contact();
                break;
            }
            // The sweep may creep between parts that nearly touch.
            if (result_.steps == many_steps) touch_.careful = true;
            if (step(window_first && result_.steps == 0)) break;
        }
        return result_;
    }

private:
    static constexpr double least_width = 0x1p-46;
    static constexpr double most_turn = 0.25; ///< radians: rotation of both bodies in one window
    static constexpr int many_steps = 256;
    static constexpr double widest_graze = 0x1p-6; ///< widest window in a graze, in which poses are decided at the ends
                                                   ///< of windows

    double next_key() const { return oncollide::next_key(task_, now_); }
    /// Wider windows cost more than they gain: the motion in them is less linear.
    double widest() const
    {
        const double spin = task_.motion_a->at(now_).angular.norm() + task_.motion_b->at(now_).angular.norm();
        return std::min(spin > most_turn ? most_turn / spin : 1, grazes_ ? widest_graze : 1);
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
    /// @param hints  hints of time 0; without contact, memory_ stays as it is
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
    bool presses() const { return task_.options.stop == SweepStop::press; }
    /// True if a contact at time 0 is the result.
    bool ends_at_begin()
    {
        const bool hidden = result_.verdict == Verdict::within && result_.kind != ContactKind::near && !inexact_;
        const bool passes = presses() || (hidden && task_.options.stop == SweepStop::contact);
        if (!passes || result_.kind == ContactKind::enclosed) return true;
        const double gap = result_.gap;
        result_.verdict = Verdict::undecided, result_.kind = ContactKind::unknown, result_.contact_by = no_bound,
        result_.separating = false;
        hinted_ = false;
        begin_graze(gap);
        return false;
    }
    /// Sets the time until which there is no contact, or only a graze.
    void move_to(double time)
    {
        now_ = time;
        (grazes_ ? result_.grazes_until : result_.clear_until) = time;
    }
    /// Examines the next window. Returns true if the result is final.
    /// @param first  the poses at time 0 are not decided yet
    bool step(bool first)
    {
        const double begin = now_, end = std::min(begin + width_, next_key());
        const MotionWindow window(task_, begin, end, touch_);
        const PartsEntry entry = entry_(window, memory_);
        if (first && entry.time <= -1 && begins_in_contact(memory_)) return ends_at_begin();
        if (entry.time > 1) {
            if (grazes_ && !presses() && certainly_meets_at(end)) return set_contact_between(window);
            move_to(end);
            width_ = std::min(2 * (end - begin), widest());
            return false;
        }
        if (!entry.direction.isZero(0)) result_.normal = entry.direction;
        const double now = std::max(begin, std::min(window.time(entry.time) * (1 - 0x1p-52), end));
        const double likely = entry.likely < after_window ? window.time(entry.likely) : end;
        move_to(now);
        tolerance_ = tolerance_in(window);
        const bool moved_on = now > begin;
        if (likely - now <= 0.5 * tolerance_ || end - begin <= tolerance_) {
            if (const auto time = contact_soon(now, end, moved_on)) return end_at(*time);
            // Parts get deeper than allowed, but rounding hides where they meet.
            if (grazes_ && end - begin <= tolerance_) return leave_open();
        }
        const double rest = end - now;
        width_ = std::clamp(2 * (likely - now), 0x1p-4 * rest, 0.5 * (end - begin));
        return !(width_ > least_width) && end_of_bounds();
    }
    /// The time of a contact soon after `now`, if one is found.
    std::optional<double> contact_soon(double now, double end, bool moved_on)
    {
        if (grazes_ && now == 0 && certainly_meets_at(0)) return 0;
        const double soon = std::min(now + tolerance_, next_key()); // after a key, the bodies may be faster
        if ((moved_on || soon != tried_) && meets_at(tried_ = soon)) return soon;
        if (end < soon && meets_at(end)) return end;
        if (end - now > tolerance_) return {};
        const double simple = simplest_between(now, end);
        if (simple != end && simple != soon && meets_at(simple)) return simple;
        return {};
    }
    /// Ends the sweep at the contact of the last decision. Returns true if this contact is the result.
    bool end_at(double time)
    {
        if (grazes_ || !presses() || found_.kind == ContactKind::enclosed) {
            set_contact(time);
            if (touch_.careful && time > 0) result_.normal = closing_normal(time);
            return true;
        }
        begin_graze(found_.bound + distance_moved(now_, time));
        return false;
    }
    /// Where parts touch all the time, other parts that get deeper soon after `time` show the direction of the contact;
    /// 0 if there are none.
    Vector3d closing_normal(double time)
    {
        constexpr double soon = 64; // times the tolerance
        const double end = std::min(now_ + soon * std::max(tolerance_, time - now_), next_key());
        if (!(end > now_)) return Vector3d::Zero();
        PairMemory none;
        const NearTouch touch = grazes_ ? touch_ : graze_of(task_, now_);
        const PartsEntry entry = entry_(MotionWindow(task_, now_, end, touch), none);
        return entry.time > 1 ? Vector3d::Zero() : entry.direction;
    }
    /// The bounds of windows do not show how the bodies move on. Returns true if nothing else does.
    bool end_of_bounds()
    {
        if (!touch_.careful) {
            touch_.careful = true, width_ = widest();
            return false;
        }
        if (grazes_ || task_.options.stop == SweepStop::touch) return leave_open();
        place(now_);
        begin_graze(tests_.distance(worker_, at_, {}, task_.solid).upper);
        return false;
    }
    /// From now on, parts may overlap by a depth.
    /// @param gap  upper bound of the distance now
    void begin_graze(double gap)
    {
        touch_ = graze_of(task_, now_);
        grazes_ = true, result_.gap = gap, result_.grazes_until = now_, tried_ = -1, width_ = widest();
    }
    /// Leaves the result open: only a graze, or rounding, was found.
    bool leave_open()
    {
        const double time = result_.clear_until;
        place(time);
        const Distance d = tests_.distance(worker_, at_, {}, task_.solid);
        result_.normal.setZero(), result_.gap = d.upper;
        const double tolerance = task_.options.gap_tolerance * (1 + 0x1p-10);
        if (!(d.upper <= tolerance + task_.clearance) || touch_.depth > tolerance) return true; // undecided
        result_.verdict = Verdict::within, result_.contact_by = time;
        result_.contact = {d.a, d.b, ContactKind::near, {d.point_a, d.point_b}, Vector3d::Zero(), Vector3d::Zero()};
        return true;
    }
    void end_without_contact()
    {
        if (grazes_)
            leave_open();
        else
            result_.verdict = Verdict::separate, result_.normal.setZero();
    }
    /// The bounds leave the window free, but it ends in a contact.
    bool set_contact_between(const MotionWindow& window)
    {
        const double tolerance = tolerance_in(window);
        double free = window.begin(), met = window.end();
        while (met - free > tolerance) {
            const double middle = 0.5 * (free + met);
            if (middle <= free || middle >= met) break;
            (certainly_meets_at(middle) ? met : free) = middle;
        }
        move_to(free), tolerance_ = tolerance, meets_at(met);
        set_contact(met);
        result_.normal = closing_normal(met);
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
    /// True if the bodies certainly meet, or come within the clearance or the error of a terrain, at this time.
    bool certainly_meets_at(double time)
    {
        const Finding found = decide(time);
        return found.verdict == Verdict::colliding || found.kind == ContactKind::near ||
               (found.verdict == Verdict::within && inexact_);
    }
    /// At the ends of the motion, undecided poses count, too.
    bool meets_at(double time)
    {
        return certainly_meets_at(time) || (found_.verdict == Verdict::within && (time == 0 || time == 1));
    }
    /// Sets the contact of the last decision.
    void set_contact(double time)
    {
        result_.verdict = found_.verdict, result_.kind = found_.kind;
        result_.contact_by = time;
        if (!grazes_) result_.gap = time > 0 ? found_.bound + distance_moved(result_.clear_until, time) : found_.bound;
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
            const Distance d = tests_.distance(worker_, at_, {}, false);
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
    NearTouch touch_;
    bool grazes_ = false; ///< the bodies are, or may be, in a contact that does not end the sweep
    double now_ = 0;      ///< the next window begins here
    double tolerance_ = 1, width_ = 1, tried_ = -1;
    bool hinted_ = false; ///< the last decision had hints, on which the parts must not depend
    bool inexact_;        ///< bodies that are apart by no more than an error or the clearance are in contact
    Isometry3d pose_a_, pose_b_;
    PairTask at_{};
    Finding found_;
};

/// A lower bound of the time of contact: the bound of the first window in which the bodies may meet.
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

/// Both results are of the same bodies.
bool tells_more(const SweepResult& x, const SweepResult& y)
{
    const auto open = [](const SweepResult& r) {
        return r.verdict == Verdict::undecided || (r.verdict == Verdict::within && r.kind != ContactKind::near);
    };
    if (open(x) != open(y)) return open(y);
    return x.clear_until > y.clear_until;
}

SweepResult swapped(SweepResult r)
{
    std::swap(r.contact.a, r.contact.b), std::swap(r.contact.ends[0], r.contact.ends[1]);
    std::swap(r.contact.normal_a, r.contact.normal_b);
    r.normal = -r.normal;
    return r;
}

} // namespace

SweepResult sweep(PairWorker& worker, const SweepTask& task, FindEntry entry, FindContact contact)
{
    if (task.bound_only) return bound_of(task, entry);
    SweepResult found = Sweep(worker, task, entry, contact).run();
    const bool stopped = found.verdict == Verdict::undecided && found.steps < task.options.most_steps;
    const bool grazes = found.grazes_until > found.clear_until || found.verdict == Verdict::within || stopped;
    found.grazes_until = std::max(found.grazes_until, found.clear_until);
    if (!grazes || task.other_order) return found;
    // Where rounding matters, either order of the bodies may find more.
    SweepTask other = task;
    std::swap(other.a, other.b), std::swap(other.motion_a, other.motion_b);
    other.other_order = true, other.memory = nullptr, other.begins_apart = false;
    const SweepResult second = tests_for(other.a->kind(), other.b->kind()).advance(worker, other);
    return tells_more(second, found) ? swapped(second) : found;
}

} // namespace oncollide
