#include "verify/trials/pair_trial.hpp"

#include <cmath>

#include <fmt/format.h>

#include <oncollide/narrowphase/fcl/exact_fcl.hpp>
#include <oncollide/pipeline/world.hpp>

#include "truth/judge.hpp"

namespace oncollide::tools {
namespace {

/// Relative rounding of the truth's square roots, and of its conversion to double.
constexpr double root_rounding = 1e-12;

struct Result {
    Finding finding;
    Distance distance;
};

Result result_of(const Settings& settings, const PlacedBody& a, const PlacedBody& b)
{
    World world(settings);
    std::array<BodyId, 2> ids;
    for (std::size_t i = 0; i < 2; ++i) {
        const PlacedBody& body = i ? b : a;
        ids[i] = world.bodies().add({.model = add_model(world, body.geometry), .pose = body.pose});
    }
    const FrameView frame = world.step();
    Result result{unlisted(settings), {}};
    if (!frame.pairs.empty()) result.finding = frame.pairs[0];
    result.distance = world.pairs().distance(ids[0], ids[1]);
    return result;
}

} // namespace

PairTruth truth_if(bool meet)
{
    PairTruth truth;
    truth.surfaces = truth.kinds = false, truth.collide = meet;
    if (meet) truth.distance.high = 0;
    return truth;
}

void try_pair(const PlacedBody& a, const PlacedBody& b, const PairTruth& given, const std::string& what, Tally& tally)
{
    ++tally.cases;
    PairTruth truth = given;
    truth.slack = std::isfinite(truth.distance.high) ? root_rounding * truth.distance.high : 0;
    const auto run = [&](const Settings& settings, const char* how) {
        const Result result = result_of(settings, a, b);
        judge(result.finding, truth, settings, fmt::format("{}: {}", how, what), tally);
        ++tally.bounds;
        if (result.distance.lower > truth.distance.high + truth.slack ||
            result.distance.upper < truth.distance.low - truth.slack)
            tally.fault(&Tally::broken, fmt::format("distance: {}", what));
        return result.finding.verdict;
    };
    const Settings exact{.exact = ExactLevel::predicates};
    const Verdict found = run(exact, "exact");
    if (!truth.surfaces && found != result_of(exact, b, a).finding.verdict)
        tally.fault(&Tally::changed, fmt::format("in the other order: {}", what));
    run({.bounding_volume = BoundingVolume::obb}, "boxes");
    run({.depth = 5, .bounding_volume = BoundingVolume::sphere}, "spheres");
    if (!truth.uncertain && fcl_available()) run({.exact = ExactLevel::fcl}, "fcl");
}

} // namespace oncollide::tools
