#include "truth/judge.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/pipeline/settings_rules.hpp>

namespace oncollide::tools {
namespace {

using Fault = Judgement::Fault;

/// The verdicts that are allowed and required.
struct Expected {
    bool may_collide, must_collide, may_be_near, must_be_near;
};

/// Rounding of the clearance test: at distances this close to the clearance both results are right (docs/results.md).
double clearance_rounding(const PairTruth& truth, double clearance)
{
    return 0x1p-16 * clearance + 0x1p-35 * truth.distance.size + 1e-139;
}

bool encloses(const PairTruth& truth, const Settings& settings)
{
    return settings.mode == Mode::solid && truth.enclosed;
}

Expected expected(const PairTruth& truth, const Settings& settings)
{
    const double clearance = settings.clearance;
    const bool enclosed = encloses(truth, settings);
    const bool touching = truth.kinds && truth.contact == TriangleContact::touching;
    const bool may_touch = touching || truth.vague || (!truth.kinds && !truth.deep);
    const bool may_meet = (truth.collide || truth.open) && !(settings.ignore_touching && touching);
    const bool must_meet = truth.collide && !(settings.ignore_touching && may_touch);
    // Distances of surfaces are exact here; distances of convex sets are rounded.
    const double high = truth.distance.high + (truth.surfaces ? 0 : truth.slack);
    Expected e{may_meet || enclosed, must_meet || enclosed,
               truth.distance.low <= clearance + clearance_rounding(truth, clearance), high <= clearance};
    e.may_be_near &= clearance > 0, e.must_be_near &= clearance > 0;
    return e;
}

/// Where FCL errs, or exact tests cannot confirm its result, a pair stays undecided. This is a fault where FCL is right
/// about surfaces and no distance matters.
bool left_open_by_fcl(const Finding& result, const PairTruth& truth, const Settings& settings)
{
    const bool open =
        (result.verdict == Verdict::within && result.kind != ContactKind::near) || result.verdict == Verdict::undecided;
    return open && decides(settings) && fcl_decides(settings) && truth.fcl_collide != truth.collide;
}

/// True if the result must be exact.
bool exact(const Finding& result, const PairTruth& truth, const Settings& settings)
{
    return decides(settings) && !truth.uncertain && !left_open_by_fcl(result, truth, settings);
}

Judgement exact_verdict(Verdict verdict, const PairTruth& truth, const Expected& e)
{
    switch (verdict) {
    case Verdict::separate:
        return e.must_collide || e.must_be_near ? Judgement{Fault::missed} : Judgement{};
    case Verdict::colliding:
        return e.may_collide ? Judgement{} : Judgement{Fault::wrong, ": false collision"};
    case Verdict::within:
        if (e.must_collide) return {Fault::wrong, ": not decided"};
        return e.may_be_near || truth.open ? Judgement{} : Judgement{Fault::wrong, ": not that near"};
    case Verdict::undecided:
        break;
    }
    return {Fault::wrong, ": not decided"};
}

/// Bounding volumes may leave any pair undecided. Bounding volumes of surfaces cannot prove a collision, except that
/// one body encloses the other.
Judgement other_verdict(Verdict verdict, const PairTruth& truth, const Expected& e, bool enclosed)
{
    if (verdict == Verdict::separate && (e.must_collide || e.must_be_near)) return {Fault::missed};
    const bool may_collide = truth.surfaces && !truth.uncertain ? enclosed : e.may_collide;
    if (verdict == Verdict::colliding && !may_collide) return {Fault::wrong, ": false collision"};
    return {};
}

bool right_kind(const Finding& result, const PairTruth& truth, const Settings& settings)
{
    if (truth.vague && result.kind == ContactKind::touching) return wants_kinds(settings);
    const ContactKind surfaces = truth.contact == TriangleContact::crossing   ? ContactKind::crossing
                                 : truth.contact == TriangleContact::touching ? ContactKind::touching
                                                                              : ContactKind::unknown;
    switch (result.verdict) {
    case Verdict::separate:
        return result.kind == (settings.ignore_touching ? surfaces : ContactKind::unknown);
    case Verdict::within:
        return result.kind == (exact(result, truth, settings) ? ContactKind::near : ContactKind::unknown);
    case Verdict::colliding:
        if (encloses(truth, settings)) return result.kind == ContactKind::enclosed;
        return result.kind == (wants_kinds(settings) ? surfaces : ContactKind::unknown);
    case Verdict::undecided:
        break;
    }
    return result.kind == ContactKind::unknown;
}

/// True if the certified bound holds.
bool holds(const Finding& result, const PairTruth& truth, const Settings& settings)
{
    const DistanceTruth& distance = truth.distance;
    const double clearance = settings.clearance;
    if (result.verdict == Verdict::colliding) return result.bound == 0;
    if (result.verdict == Verdict::separate)
        return truth.collide || (result.bound >= clearance && result.bound <= distance.high + truth.slack);
    const bool near = result.verdict != Verdict::within || !exact(result, truth, settings) || truth.open ||
                      result.bound <= clearance + clearance_rounding(truth, clearance);
    return distance.low <= result.bound + truth.slack && near && std::isfinite(result.bound);
}

} // namespace

bool decides(const Settings& settings)
{
    return exact_level(settings) != ExactLevel::off && !settings.skip.contains(StageId::exact);
}

bool fcl_decides(const Settings& settings)
{
    return exact_level(settings) == ExactLevel::fcl;
}

bool must_be_left_over(const PairTruth& truth, const Settings& settings)
{
    const Expected e = expected(truth, settings);
    return e.must_collide || e.must_be_near;
}

Judgement judge(const Finding& result, const PairTruth& truth, const Settings& settings)
{
    const bool enclosed = encloses(truth, settings);
    const Expected e = expected(truth, settings);
    // A pair may stay undecided if a budget has no room to decide it; its bound is still checked.
    const bool no_room = result.verdict == Verdict::undecided && (settings.node_budget || settings.memory_budget);
    Judgement judgement = !exact(result, truth, settings) ? other_verdict(result.verdict, truth, e, enclosed)
                          : no_room                       ? Judgement{}
                                                          : exact_verdict(result.verdict, truth, e);
    if (judgement.fault == Fault::none && truth.kinds && !right_kind(result, truth, settings))
        judgement = {Fault::wrong, ": wrong kind"};
    const bool open = result.verdict == Verdict::within || result.verdict == Verdict::undecided;
    const bool near = settings.clearance > 0 && truth.distance.low <= settings.clearance;
    judgement.false_positive = open && !e.may_collide && !near;
    judgement.broken = !holds(result, truth, settings);
    return judgement;
}

std::string described(const Finding& result, const PairTruth& truth, const Judgement& judgement)
{
    return fmt::format("{}, of kind {}{}; bound {:.9g} m, distance {:.9g} to {:.9g} m", name_of(result.verdict),
                       name_of(result.kind), judgement.why, result.bound, truth.distance.low, truth.distance.high);
}

void judge(const Finding& result, const PairTruth& truth, const Settings& settings, const std::string& what,
           Tally& tally)
{
    const Judgement judgement = judge(result, truth, settings);
    ++tally.results;
    tally.bounds += result.verdict != Verdict::colliding;
    tally.false_positives += judgement.false_positive;
    const auto fault = [&](std::uint64_t Tally::*kind) {
        tally.fault(kind, fmt::format("{}: {}", what, described(result, truth, judgement)));
    };
    if (judgement.fault == Fault::missed) fault(&Tally::missed);
    if (judgement.fault == Fault::wrong) fault(&Tally::wrong);
    if (judgement.broken) fault(&Tally::broken);
}

} // namespace oncollide::tools
