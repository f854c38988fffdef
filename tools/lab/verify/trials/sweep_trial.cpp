#include "verify/trials/sweep_trial.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>

#include "truth/judge.hpp"
#include "verify/cases/placed_body.hpp"

namespace oncollide::tools {
namespace {

const char* kind_of(const GeometryData& geometry)
{
    if (std::holds_alternative<OccupancyMap>(geometry)) return "map";
    if (std::holds_alternative<Terrain>(geometry)) return "terrain";
    const auto* shape = std::get_if<Shape>(&geometry);
    if (!shape) return "mesh";
    constexpr const char* names[] = {"sphere", "box", "capsule", "cylinder", "hull", "ellipsoid", "cone", "half-space"};
    static_assert(std::variant_size_v<Shape> == std::size(names));
    return names[shape->index()];
}

bool is_half_space(const GeometryData& geometry)
{
    const auto* shape = std::get_if<Shape>(&geometry);
    return shape && std::holds_alternative<HalfSpace>(*shape);
}

/// With a clearance, a World decides exactly only on request.
Settings exactly(Settings settings)
{
    settings.exact = ExactLevel::predicates;
    return settings;
}

/// Judges single poses of two bodies on their ways.
class Poses {
public:
    virtual ~Poses() = default;
    virtual bool must_meet(double time) = 0; ///< or come within the clearance
    virtual bool may_meet(double time) = 0;
    virtual bool confirms(double time) = 0;         ///< a contact that is reported as certain
    virtual double least_distance(double time) = 0; ///< less rounding
};

class TruePoses final : public Poses {
public:
    TruePoses(const DrawnSweep& drawn, SweepTally& tally)
        : drawn_(drawn), tally_(tally), a_(drawn.a, drawn.settings.mode == Mode::solid),
          b_(drawn.b, drawn.settings.mode == Mode::solid)
    {
    }
    bool must_meet(double time) override
    {
        return must_be_left_over(at(time, drawn_.settings.clearance > 0), drawn_.settings);
    }
    bool may_meet(double time) override
    {
        const Settings& s = drawn_.settings;
        if (a_.is_uncertain() || b_.is_uncertain()) return true;
        const PairTruth truth = at(time, s.clearance > 0);
        if (truth.collide || truth.open || (s.mode == Mode::solid && truth.enclosed)) return true;
        const double rounding = 0x1p-16 * s.clearance + 0x1p-35 * truth.distance.size;
        return s.clearance > 0 && truth.distance.low <= s.clearance + rounding;
    }
    bool confirms(double time) override { return may_meet(time); }
    double least_distance(double time) override
    {
        const PairTruth then = at(time, true);
        return then.distance.low - then.slack - 0x1p-30 * then.distance.size;
    }

private:
    PairTruth at(double time, bool distance)
    {
        ++tally_.truths;
        const Eigen::Isometry3d pose_a = drawn_.motion_a.pose(time), pose_b = drawn_.motion_b.pose(time);
        PairTruth truth = truth_of(a_, pose_a, b_, pose_b, {.kinds = false, .deep = false, .distance = false});
        if (distance) measure(truth, a_, pose_a, b_, pose_b);
        return truth;
    }

    const DrawnSweep& drawn_;
    SweepTally& tally_;
    TruthModel a_, b_;
};

class TestedPoses final : public Poses {
public:
    TestedPoses(const DrawnSweep& drawn, SweepTally& tally)
        : drawn_(drawn), tally_(tally),
          world_(drawn.settings), a_{add_model(world_, drawn.a)}, b_{add_model(world_, drawn.b)},
          exact_(exactly(drawn.settings)), exact_a_{add_model(exact_, drawn.a)}, exact_b_{add_model(exact_, drawn.b)}
    {
    }
    bool must_meet(double time) override
    {
        place(time);
        const Finding found = world_.pairs().decide(a_, b_);
        return found.verdict == Verdict::colliding || found.kind == ContactKind::near;
    }
    bool may_meet(double time) override
    {
        place(time);
        if (world_.pairs().decide(a_, b_).verdict != Verdict::separate) return true;
        // A witness counts up to the rounding of the clearance (docs/results.md), which the search for one does not
        // use.
        const double clearance = drawn_.settings.clearance;
        return clearance > 0 && world_.pairs().distance(a_, b_).lower <= clearance * (1 + 0x1p-16);
    }
    bool confirms(double time) override
    {
        place(time);
        exact_a_.pose = a_.pose, exact_b_.pose = b_.pose;
        return exact_.pairs().decide(exact_a_, exact_b_).verdict == Verdict::colliding;
    }
    double least_distance(double time) override
    {
        place(time);
        return world_.pairs().distance(a_, b_).lower;
    }

private:
    void place(double time)
    {
        ++tally_.poses;
        a_.pose = drawn_.motion_a.pose(time), b_.pose = drawn_.motion_b.pose(time);
    }

    const DrawnSweep& drawn_;
    SweepTally& tally_;
    World world_;
    PlacedModel a_, b_;
    World exact_;
    PlacedModel exact_a_, exact_b_;
};

bool certain(const SweepResult& r)
{
    return r.verdict == Verdict::colliding || (r.verdict == Verdict::within && r.kind == ContactKind::near);
}

} // namespace

SweepTally& SweepTally::operator+=(const SweepTally& o)
{
    sweeps += o.sweeps, contacts += o.contacts, at_start += o.at_start, clear += o.clear, open += o.open;
    poses += o.poses, truths += o.truths, missed += o.missed, early += o.early, wide += o.wide, changed += o.changed;
    return *this;
}

SweepResult sweep_of(const DrawnSweep& drawn, bool swapped)
{
    World world(drawn.settings);
    const MovingModel a{add_model(world, drawn.a), drawn.motion_a}, b{add_model(world, drawn.b), drawn.motion_b};
    return swapped ? world.pairs().sweep(b, a) : world.pairs().sweep(a, b);
}

std::string fault_in(const DrawnSweep& drawn, const SweepResult& r, const SweepResult& swapped, std::uint64_t seed,
                     PoseJudge judge, SweepTally& tally)
{
    constexpr int samples = 5;
    const SweepOptions options;
    std::unique_ptr<Poses> poses;
    if (judge == PoseJudge::truth)
        poses = std::make_unique<TruePoses>(drawn, tally);
    else
        poses = std::make_unique<TestedPoses>(drawn, tally);
    std::vector<double> before{0, r.clear_until * (1 - 0x1p-52)};
    for (std::uint64_t k = 0; k < samples; ++k) before.push_back(r.clear_until * u01(seed, 77, k));
    if (r.verdict == Verdict::separate) before.push_back(1);
    for (const double time : before)
        if ((time < r.clear_until || r.verdict == Verdict::separate) && poses->must_meet(time))
            return ++tally.missed, fmt::format("{}, clear until {:.17g}, but they meet at {:.17g}", name_of(r.verdict),
                                               r.clear_until, time);
    const bool collides = r.verdict == Verdict::colliding;
    if (certain(r) && !(collides ? poses->confirms(r.contact_by) : poses->may_meet(r.contact_by)))
        return ++tally.early, fmt::format("{} by {:.17g}, but they do not meet then", name_of(r.verdict), r.contact_by);
    if (r.verdict != Verdict::separate && r.verdict != Verdict::undecided) {
        // Where one solid encloses the other, their surfaces are apart.
        const double distance = r.kind == ContactKind::enclosed ? 0 : poses->least_distance(r.clear_until);
        const bool bracket = r.contact_by - r.grazes_until <= options.time_tolerance * (1 + 1e-12),
                   gap = r.verdict != Verdict::colliding || r.gap <= options.gap_tolerance * (1 + 1e-3) ||
                         (is_half_space(drawn.a) && is_half_space(drawn.b) && std::isinf(r.gap));
        if (!bracket || !gap || distance > r.gap + drawn.settings.clearance)
            return ++tally.wide, fmt::format("{} from {:.17g} to {:.17g}, gap {:g} m, distance {:g} m",
                                             name_of(r.verdict), r.clear_until, r.contact_by, r.gap, distance);
    }
    if ((certain(swapped) && r.clear_until > swapped.contact_by) || (certain(r) && swapped.clear_until > r.contact_by))
        return ++tally.changed, fmt::format("{} from {:.17g} to {:.17g}, but {} from {:.17g} to {:.17g} swapped",
                                            name_of(r.verdict), r.clear_until, r.contact_by, name_of(swapped.verdict),
                                            swapped.clear_until, swapped.contact_by);
    return {};
}

namespace {

std::string fault_of(std::uint64_t seed, const DrawnSweep& drawn, SweepTally& tally)
try {
    constexpr std::uint64_t by_truth = 16;
    const SweepResult r = sweep_of(drawn);
    ++tally.sweeps;
    ++(r.verdict == Verdict::separate ? tally.clear
       : !certain(r)                  ? tally.open
       : r.contact_by > 0             ? tally.contacts
                                      : tally.at_start);
    const SweepResult swapped = sweep_of(drawn, true);
    const std::string fault = fault_in(drawn, r, swapped, seed, PoseJudge::exact_tests, tally);
    return !fault.empty() || seed % by_truth ? fault : fault_in(drawn, r, swapped, seed, PoseJudge::truth, tally);
} catch (const std::exception& error) {
    return ++tally.changed, fmt::format("error: {}", error.what());
}

} // namespace

SweepTallies& SweepTallies::operator+=(const SweepTallies& o)
{
    for (const auto& [kinds, tally] : o) (*this)[kinds] += tally;
    first += o.first;
    return *this;
}

SweepTallies try_sweeps(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done)
{
    const auto run = [](std::uint64_t seed, SweepTallies& tallies) {
        const DrawnSweep drawn = draw_sweep(seed);
        SweepTally& tally = tallies[std::minmax<std::string>(kind_of(drawn.a), kind_of(drawn.b))];
        tallies.first.take(seed, fault_of(seed, drawn, tally));
    };
    return sum_of_seeds<SweepTallies>(first, count, threads, run, done);
}

} // namespace oncollide::tools
