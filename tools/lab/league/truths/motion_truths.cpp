// Truths in extended precision: a shape that moves until it meets a convex part.
#include <algorithm>
#include <cmath>

#include "league/truths/solids.hpp"
#include "league/truths/truths.hpp"

namespace oncollide::tools::truths {
namespace {

using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidGap;
using oracle::SolidTruth;
using Meet = LeagueTruth::Meet;

/// How far any point of b moves at most, in all.
long double way_of(const LeagueCase& asked)
{
    const Aabb box = bounds_of(asked.b.geometry);
    const double reach = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm();
    return asked.motion.cast<long double>().norm() + asked.turn.cast<long double>().norm() * reach;
}

/// The shape b moves toward a convex part of a. They meet where their gap is below rounding.
class Approach {
public:
    Approach(const LeagueCase& asked, const SolidTruth& a)
        : asked_(asked), a_(a), b_(moved(0)), motion_(asked.motion.cast<long double>()), way_(way_of(asked)),
          size_(asked.a.size() + asked.b.size()), rounding_(1e-15L * (size_ + way_))
    {
    }

    /// The time of the first contact, its bounds, or the least gap.
    LeagueTruth contact() const
    {
        LeagueTruth truth;
        if (gap(0) == 0) {
            truth.meet = Meet::yes, truth.lower = truth.upper = 0;
            truth.gap = -size_; // a cast that begins in contact must not be lost
            return truth;
        }
        return asked_.turn.isZero() ? straight_contact() : turning_contact();
    }

    /// How deep b is in a at most between two times; negative: how far apart they are at least.
    long double deepest(long double from, long double to) const
    {
        const int steps = asked_.turn.isZero() ? 1 : 24; // the depth of a straight motion is a concave function of time
        long double most = std::max(depth(from), depth(to));
        for (int k = 0; k < steps && to > from; ++k)
            most = std::max(most, peak(from + (to - from) * k / steps, from + (to - from) * (k + 1) / steps));
        return most;
    }

private:
    /// The gap is a convex function of time: its least value by golden sections, the first root before it by bisection.
    LeagueTruth straight_contact() const
    {
        LeagueTruth truth;
        long double low = 0, high = 1;
        for (int k = 0; k < 200 && gap(high) > 0 && high - low > 1e-12L; ++k) {
            const long double p = low + 0.382L * (high - low), q = high - 0.382L * (high - low);
            const long double at_p = gap(p), at_q = gap(q);
            if (at_p == 0) {
                high = p;
            } else if (at_q == 0) {
                high = q;
            } else if (at_p < at_q) {
                high = q;
            } else {
                low = p;
            }
        }
        if (gap(high) > 0) return passed(low, high, std::min(gap(high), gap(low)));
        const long double met = high;
        std::tie(truth.lower, truth.upper) = root(0, high);
        if (!surely_met(truth.upper)) truth.upper = met; // a sliver, whose gap is known less well
        truth.meet = surely_met(truth.upper) ? Meet::yes : Meet::open;
        return truth;
    }

    /// Conservative advancement: in the time until b has moved by its gap, they cannot meet. It takes half of that.
    LeagueTruth turning_contact() const
    {
        constexpr int most_steps = 4000;
        long double t = 0, apart = gap(0), least = apart;
        for (int k = 0; k < most_steps && apart > 1e-12L * size_; ++k) {
            least = std::min(least, apart / 2);
            t += apart / 2 / way_;
            if (t >= 1) return passed(1, 1, least);
            apart = gap(t);
        }
        LeagueTruth truth;
        truth.lower = t;
        long double before = t, after = t;
        for (long double step = 1e-15L; after < 1 && !surely_met(after); step *= 2)
            before = after, after = std::min(1.0L, t + step);
        truth.meet = surely_met(after) ? Meet::yes : Meet::open;
        if (truth.meet == Meet::yes) truth.upper = root(before, after).second;
        return truth;
    }

    LeagueTruth passed(long double lower, long double upper, long double gap) const
    {
        LeagueTruth truth;
        truth.gap = gap, truth.lower = lower, truth.upper = upper;
        truth.meet = gap > 1e-9L * size_ ? Meet::no : Meet::open;
        return truth;
    }

    /// Bounds of a time after `low` from which on they have no gap, until `high`.
    std::pair<long double, long double> root(long double low, long double high) const
    {
        while (high - low > 1e-16L) {
            const long double middle = (low + high) / 2;
            if (middle <= low || middle >= high) break;
            (gap(middle) > 0 ? low : high) = middle;
        }
        return {low, high};
    }

    /// The greatest depth by golden sections, if the depth is a concave function of time.
    long double peak(long double from, long double to) const
    {
        long double most = depth(to);
        for (int k = 0; k < (asked_.turn.isZero() ? 40 : 4); ++k) {
            const long double p = from + 0.382L * (to - from), q = to - 0.382L * (to - from);
            const long double at_p = depth(p), at_q = depth(q);
            most = std::max({most, at_p, at_q});
            if (at_p >= at_q)
                to = q;
            else
                from = p;
        }
        return most;
    }

    SolidTruth moved(long double t) const
    {
        return SolidTruth(std::get<Shape>(asked_.b.geometry), asked_.pose_of_b(double(t)), a_.origin());
    }
    SolidGap gap_at(long double t) const
    {
        return asked_.turn.isZero() ? gap_of(a_, b_, t * motion_) : gap_of(a_, moved(t));
    }
    long double gap(long double t) const
    {
        const long double lower = gap_at(t).lower;
        return lower > rounding_ ? lower : 0;
    }
    bool surely_met(long double t) const { return gap_at(t).upper <= 4 * rounding_; }
    long double depth(long double t) const
    {
        const SolidTruth b = moved(t);
        const SolidGap found = gap_of(a_, b);
        return found.upper > rounding_ ? -found.upper : least_width(a_, b, found, LongVector::UnitZ()).width;
    }

    const LeagueCase& asked_;
    const SolidTruth& a_;
    SolidTruth b_;
    LongVector motion_;
    long double way_, size_, rounding_;
};

struct Cast {
    LeagueCase asked;
    std::vector<SolidTruth> parts;
};

} // namespace

LeagueTruth first_contact(const LeagueCase& asked)
{
    LeagueTruth truth{.way = way_of(asked), .size = asked.a.size() + asked.b.size()};
    truth.coordinate =
        std::max({asked.a.pose.translation().cwiseAbs().maxCoeff(), asked.b.pose.translation().cwiseAbs().maxCoeff(),
                  asked.motion.cwiseAbs().maxCoeff()}) +
        truth.size;
    const auto cast = std::make_shared<const Cast>(Cast{asked, parts_of(asked.a, asked.a.pose.translation(), true)});
    long double least = std::numeric_limits<long double>::infinity(), maybe = least;
    truth.meet = Meet::no;
    for (const SolidTruth& part : cast->parts) {
        const Approach approach(cast->asked, part);
        const LeagueTruth found = approach.contact();
        if (found.meet != Meet::yes) {
            least = std::min(least, found.gap);
            if (found.meet == Meet::open) maybe = std::min(maybe, found.lower);
            continue;
        }
        truth.lower = truth.meet == Meet::yes ? std::min(truth.lower, found.lower) : found.lower;
        truth.upper = std::min(truth.upper, found.upper), truth.meet = Meet::yes;
        // How deep they get later: rounding may lose a graze.
        const long double deep = found.gap < 0 ? -found.gap : approach.deepest(found.upper, 1);
        truth.gap = std::min(truth.gap, -deep);
    }
    if (truth.meet == Meet::yes) {
        truth.lower = std::min(truth.lower, maybe); // rounding decides whether another part was met before
        truth.deepest = [cast](long double from, long double to) {
            long double most = -std::numeric_limits<long double>::infinity();
            for (const SolidTruth& part : cast->parts)
                most = std::max(
                    most,
                    Approach(cast->asked, part).deepest(std::clamp(from, 0.0L, 1.0L), std::clamp(to, 0.0L, 1.0L)));
            return most;
        };
    } else {
        truth.gap = least;
        if (std::isfinite(maybe)) truth.meet = Meet::open;
    }
    return truth;
}

bool contact_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    if (truth.meet == Meet::open) return true;
    const auto apart_at = [&](long double t) {
        LeagueBody moved = asked.b;
        moved.pose = asked.pose_of_b(double(t));
        return true_distance(sets_of(asked.a), sets_of(moved));
    };
    const long double rounding = 1e-9L * truth.size + 1e-14L * truth.coordinate;
    const bool meet = truth.meet == Meet::yes;
    for (int k = 0; k <= 16; ++k)
        if (const long double t = (meet ? truth.lower * 0.999L : 1) * k / 16; t > 0 && apart_at(t).upper <= 0)
            return false;
    return !meet || apart_at(truth.upper).lower <= rounding;
}

} // namespace oncollide::tools::truths
