#include "hard/body_judge.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

/// The verdicts that are allowed and required of an exact level.
struct Expected {
    bool may_collide, must_collide, may_be_near, must_be_near;
};

/// Rounding of the clearance test: at distances this close to the clearance both results are right (docs/results.md).
double clearance_rounding(const PairTruth& truth, double clearance)
{
    return 0x1p-16 * clearance + 0x1p-35 * truth.surfaces.distance.size + 1e-139;
}

Expected expected(const PairTruth& truth, const Settings& settings)
{
    const bool collide = truth.surfaces.collide;
    const DistanceTruth& distance = truth.surfaces.distance;
    const double clearance = settings.clearance;
    const bool enclosed = settings.mode == Mode::solid && truth.solids.enclosed;
    const bool touching = truth.solids.contact == TriangleContact::touching;
    const bool may_meet = collide && !(settings.ignore_touching && touching);
    const bool must_meet = may_meet && !(settings.ignore_touching && truth.solids.vague);
    Expected e{may_meet || enclosed, must_meet || enclosed,
               distance.low <= clearance + clearance_rounding(truth, clearance), distance.high <= clearance};
    e.may_be_near &= clearance > 0, e.must_be_near &= clearance > 0;
    return e;
}

/// Null: the verdict is correct.
struct Fault {
    std::uint64_t Tally::*kind = nullptr;
    const char* why = "";
};

Fault fault_of_exact(Verdict verdict, const Expected& e)
{
    switch (verdict) {
    case Verdict::separate:
        return e.must_collide || e.must_be_near ? Fault{&Tally::missed, ""} : Fault{};
    case Verdict::colliding:
        return e.may_collide ? Fault{} : Fault{&Tally::wrong, ": false collision"};
    case Verdict::within:
        if (e.must_collide) return {&Tally::wrong, ": not decided"};
        return e.may_be_near ? Fault{} : Fault{&Tally::wrong, ": not that near"};
    case Verdict::undecided:
        break;
    }
    return {&Tally::wrong, ": not decided"};
}

/// Spheres may leave any pair undecided, and may report solids as enclosed.
Fault fault_of_spheres(const BodyResult& result, const PairTruth& truth, const Settings& settings)
{
    const bool enclosed = settings.mode == Mode::solid && truth.solids.enclosed;
    const bool near = settings.clearance > 0 && truth.surfaces.distance.high <= settings.clearance;
    if (result.verdict == Verdict::separate && (truth.surfaces.collide || enclosed || near))
        return {&Tally::missed, ""};
    if (result.verdict == Verdict::colliding && !enclosed) return {&Tally::wrong, ": false collision"};
    return {};
}

/// Where FCL errs, or exact tests cannot confirm its result, a pair stays undecided. This is a fault where FCL is right
/// about surfaces and no distance matters.
bool left_open_by_fcl(const BodyResult& result, const PairTruth& truth, const Settings& settings)
{
    const bool open =
        (result.verdict == Verdict::within && result.kind != ContactKind::near) || result.verdict == Verdict::undecided;
    return open && decides(settings) && fcl_decides(settings) && truth.fcl_collide != truth.surfaces.collide;
}

bool right_kind(const BodyResult& result, const PairTruth& truth, const Settings& settings, bool exact)
{
    if (truth.solids.vague && result.kind == ContactKind::touching) return wants_kinds(settings);
    const ContactKind surfaces = truth.solids.contact == TriangleContact::crossing   ? ContactKind::crossing
                                 : truth.solids.contact == TriangleContact::touching ? ContactKind::touching
                                                                                     : ContactKind::unknown;
    const bool solid = settings.mode == Mode::solid;
    switch (result.verdict) {
    case Verdict::separate:
        return result.kind == (settings.ignore_touching ? surfaces : ContactKind::unknown);
    case Verdict::within:
        return result.kind == (exact ? ContactKind::near : ContactKind::unknown);
    case Verdict::colliding:
        if (solid && truth.solids.enclosed) return result.kind == ContactKind::enclosed;
        return result.kind == (wants_kinds(settings) ? surfaces : ContactKind::unknown);
    case Verdict::undecided:
        break;
    }
    return result.kind == ContactKind::unknown;
}

/// True if the certified bound holds.
bool holds(const BodyResult& result, const PairTruth& truth, const Settings& settings)
{
    const DistanceTruth& distance = truth.surfaces.distance;
    const double clearance = settings.clearance, rounding = 0x1p-50 * distance.size;
    const bool exact = decides(settings) && !left_open_by_fcl(result, truth, settings);
    if (result.verdict == Verdict::colliding) return result.bound == 0;
    if (result.verdict == Verdict::separate) {
        const double bound = result.listed ? result.bound : clearance;
        return truth.surfaces.collide || (bound >= clearance && bound <= distance.high + rounding);
    }
    const bool near =
        result.verdict != Verdict::within || !exact || result.bound <= clearance + clearance_rounding(truth, clearance);
    return distance.low <= result.bound + rounding && near && std::isfinite(result.bound);
}

} // namespace

bool decides(const Settings& settings)
{
    return settings.exact != ExactLevel::off && !settings.skip.contains(StageId::exact);
}

bool fcl_decides(const Settings& s)
{
    return s.exact == ExactLevel::fcl;
}

void judge(const PairTruth& truth, const Settings& settings, const BodyResult& result, Tally& tally,
           const std::string& what)
{
    ++tally.results;
    const bool exact = decides(settings) && !left_open_by_fcl(result, truth, settings);
    // A pair may stay undecided if a budget has no room to decide it; its bound is still checked.
    const bool no_room = result.verdict == Verdict::undecided && (settings.node_budget || settings.memory_budget);
    const Fault fault = !exact    ? fault_of_spheres(result, truth, settings)
                        : no_room ? Fault{}
                                  : fault_of_exact(result.verdict, expected(truth, settings));
    if (fault.kind)
        tally.fault(fault.kind, fmt::format("{}: {}{}", what, name_of(result.verdict), fault.why));
    else if (!right_kind(result, truth, settings, exact))
        tally.fault(&Tally::wrong,
                    fmt::format("{}: {}, of kind {}", what, name_of(result.verdict), name_of(result.kind)));
    const bool enclosed = settings.mode == Mode::solid && truth.solids.enclosed;
    const bool open = result.verdict == Verdict::within || result.verdict == Verdict::undecided;
    const bool near = settings.clearance > 0 && truth.surfaces.distance.low <= settings.clearance;
    tally.false_positives += open && !truth.surfaces.collide && !enclosed && !near;
    tally.bounds += result.verdict != Verdict::colliding;
    if (!holds(result, truth, settings))
        tally.fault(&Tally::broken,
                    fmt::format("{}: {}, bound {:.9g} m, distance {:.9g} to {:.9g} m", what, name_of(result.verdict),
                                result.bound, truth.surfaces.distance.low, truth.surfaces.distance.high));
}

} // namespace oncollide::tools
