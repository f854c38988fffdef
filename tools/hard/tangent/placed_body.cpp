#include "hard/tangent/placed_body.hpp"

#include <octomap/OcTree.h>

#include <oncollide/pipeline/world.hpp>

#include "peers/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

struct Result {
    Verdict verdict = Verdict::separate;
    double bound = 0;
    Distance distance;
};

Result result_of(const Settings& settings, const PlacedBody& a, const PlacedBody& b)
{
    World world(settings);
    std::array<BodyId, 2> ids;
    for (std::size_t i = 0; i < 2; ++i) {
        const PlacedBody& body = i ? b : a;
        const ModelId model = std::visit([&](const auto& g) { return world.add(g); }, body.geometry);
        ids[i] = world.add_body({.model = model, .pose = body.pose});
    }
    const FrameView frame = world.step();
    Result result;
    if (!frame.pairs.empty()) result = {frame.pairs[0].verdict, frame.pairs[0].bound, {}};
    result.distance = world.distance(ids[0], ids[1]);
    return result;
}

} // namespace

OccupancyMap one_cell(double side)
{
    octomap::OcTree tree(side);
    tree.updateNode(octomap::OcTreeKey(32768, 32768, 32768), true);
    return make_occupancy_map(tree);
}

void judge_meeting(const PlacedBody& a, const PlacedBody& b, bool meet, const std::string& what, Tally& tally)
{
    ++tally.cases;
    const auto judge = [&](const Settings& settings, bool exact, const char* how) {
        ++tally.results;
        const Verdict v = result_of(settings, a, b).verdict;
        if (v == Verdict::separate && meet) tally.fault(&Tally::missed, fmt::format("{}: {}", how, what));
        if ((v == Verdict::colliding && !meet) || (exact && v != (meet ? Verdict::colliding : Verdict::separate)))
            tally.fault(&Tally::wrong, fmt::format("{}: {}", how, what));
        tally.false_positives += v == Verdict::within && !meet;
    };
    judge({.exact = ExactLevel::predicates}, true, "exact");
    judge({.bounding_volume = BoundingVolume::obb}, false, "boxes");
    judge({.depth = 5, .bounding_volume = BoundingVolume::sphere}, false, "spheres");
    judge({.exact = ExactLevel::fcl}, false, "fcl");
    const FclGeometry fcl_a = make_fcl_geometry(a.geometry, FclNodes::obb),
                      fcl_b = make_fcl_geometry(b.geometry, FclNodes::obb);
    const bool theirs = fcl_contacts({fcl_a, a.pose}, {fcl_b, b.pose}) > 0;
    tally.fcl_missed += meet && !theirs, tally.fcl_false += theirs && !meet;
}

void judge_bounds(const PlacedBody& a, const PlacedBody& b, long double distance, const std::string& what, Tally& tally)
{
    ++tally.cases;
    constexpr long double rounding = 1e-12L; // of the truth's square roots, and of its conversion to double
    const bool meet = distance == 0;
    const auto judge = [&](const Settings& settings, const char* how) {
        ++tally.results, tally.bounds += 2;
        const Result r = result_of(settings, a, b);
        if (r.verdict == Verdict::separate && meet) tally.fault(&Tally::missed, fmt::format("{}: {}", how, what));
        if (r.verdict == Verdict::colliding && !meet) tally.fault(&Tally::wrong, fmt::format("{}: {}", how, what));
        const bool broken = r.verdict == Verdict::separate
                                ? r.bound > distance * (1 + rounding)
                                : r.bound < distance * (1 - rounding) && r.verdict != Verdict::colliding;
        if (broken) tally.fault(&Tally::broken, fmt::format("{}: {}", how, what));
        if (r.distance.lower > distance * (1 + rounding) || r.distance.upper < distance * (1 - rounding))
            tally.fault(&Tally::broken, fmt::format("distance: {}", what));
        tally.false_positives += r.verdict == Verdict::within && !meet;
    };
    judge({.exact = ExactLevel::predicates}, "exact");
    judge({.bounding_volume = BoundingVolume::obb}, "boxes");
    judge({.depth = 5, .bounding_volume = BoundingVolume::sphere}, "spheres");
}

} // namespace oncollide::tools
