#include "study/accuracy_check.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "verify/oracle/convex_truth.hpp"

namespace oncollide::tools {
namespace {

std::string names_of(const Scene& scene, BodyPair pair)
{
    return fmt::format("{} and {}", scene.label(SceneBodyId{pair.a}), scene.label(SceneBodyId{pair.b}));
}

/// Largest error of FCL's distance: 1e-9 of the bodies' size, plus the rounding of doubles far from the origin.
double distance_rounding(const Scene& scene, const PairResult& pair, bool has_shape)
{
    double size = 0, far = 0;
    for (const BodyId body : {pair.a, pair.b}) {
        const Aabb box = bounds_of(scene.geometries[index(scene.geometry[index(body)])]);
        size += box.diagonal();
        far = std::max({far, scene.poses[index(body)].translation().cwiseAbs().maxCoeff(),
                        box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff()});
    }
    return 1e-9 * size + 4e-15 * far + (has_shape ? shape_rounding : 0);
}

/// FCL reports some overlapping pairs of a hull and a mesh as separate, so extended precision decides when FCL says no.
/// Not for maps and terrains, which have too many cells.
bool truly_meet(const Scene& scene, BodyPair pair)
{
    const auto sets = [&](std::uint32_t body) {
        const GeometryData& geometry = scene.geometries[index(scene.geometry[body])].data;
        const bool large = std::holds_alternative<OccupancyMap>(geometry) || std::holds_alternative<Terrain>(geometry);
        return large ? std::vector<ConvexSet>{} : convex_sets(geometry, scene.poses[body]);
    };
    const std::vector<ConvexSet> a = sets(pair.a), b = sets(pair.b);
    return !a.empty() && !b.empty() && true_distance(a, b).lower < shape_rounding;
}

} // namespace

Comparison& Comparison::operator+=(const Comparison& o)
{
    pairs += o.pairs, left_over += o.left_over, undecided += o.undecided, colliding += o.colliding;
    fcl_colliding += o.fcl_colliding, false_positives += o.false_positives, missed += o.missed;
    missed_by_rounding += o.missed_by_rounding, wrong_exact += o.wrong_exact;
    if (first_missed.empty()) first_missed = o.first_missed;
    return *this;
}

Comparison compare(const Scene& scene, const FrameView& frame, const Settings& settings, const FclFrame& fcl,
                   const FclWorld& world)
{
    Comparison result;
    result.pairs = frame.pairs.size(), result.fcl_colliding = fcl.colliding.size();
    const auto miss = [&](BodyPair pair) {
        if (world.has_shape(pair) && world.penetration(pair) <= shape_rounding) {
            ++result.missed_by_rounding;
            return;
        }
        ++result.missed;
        if (result.first_missed.empty())
            result.first_missed = fmt::format("frame {}: {}", frame.frame, names_of(scene, pair));
    };
    auto theirs = fcl.colliding.begin();
    for (const PairResult& ours : frame.pairs) { // both lists are sorted
        const BodyPair pair{index(ours.a), index(ours.b)};
        while (theirs != fcl.colliding.end() && *theirs < pair) miss(*theirs++);
        const bool collides = theirs != fcl.colliding.end() && *theirs == pair;
        theirs += collides;
        const bool left_over = ours.verdict != Verdict::separate, colliding = ours.verdict == Verdict::colliding;
        result.left_over += left_over, result.colliding += colliding;
        result.undecided += ours.verdict == Verdict::undecided;
        result.false_positives += left_over && !collides;
        const bool ignored = settings.ignore_touching && ours.kind == ContactKind::touching;
        if (collides && !left_over && !ignored) miss(pair);
        // Solid mode also finds bodies inside bodies, which FCL does not.
        if (settings.exact != ExactLevel::off && colliding && !collides && settings.mode == Mode::surface)
            result.wrong_exact += !(world.has_shape(pair) && truly_meet(scene, pair));
    }
    while (theirs != fcl.colliding.end()) miss(*theirs++);
    return result;
}

BoundCheck& BoundCheck::operator+=(const BoundCheck& o)
{
    checks += o.checks, violations += o.violations;
    least_margin = std::min(least_margin, o.least_margin);
    largest_bound = std::max(largest_bound, o.largest_bound);
    if (first_violation.empty()) first_violation = o.first_violation;
    return *this;
}

BoundCheck check_bound(const Scene& scene, const PairResult& pair, const Settings& settings, double distance,
                       bool has_shape)
{
    BoundCheck check;
    if (pair.verdict == Verdict::colliding) return check; // compare() checks these
    check.checks = 1;
    const bool separate = pair.verdict == Verdict::separate;
    check.least_margin = separate ? distance - pair.bound : pair.bound - distance;
    if (pair.verdict == Verdict::within) check.largest_bound = pair.bound;
    const double allowed = distance_rounding(scene, pair, has_shape);
    const bool inside_clearance = separate && distance < settings.clearance - allowed;
    check.violations = check.least_margin < -allowed || inside_clearance;
    if (check.violations)
        check.first_violation =
            fmt::format("{}: {}, bound {:.9g} m, but FCL's distance is {:.9g} m",
                        names_of(scene, {index(pair.a), index(pair.b)}), name_of(pair.verdict), pair.bound, distance);
    return check;
}

} // namespace oncollide::tools
