// Two shapes, and shapes on ground.
#include <fmt/format.h>

#include "league/families/families.hpp"
#include "league/truths/truths.hpp"
#include "verify/cases/drawn_shapes.hpp"
#include "verify/oracle/solid_gap.hpp"

namespace oncollide::tools {
namespace {

using oracle::SolidTruth;

struct KindPairs {
    const char* name;
    std::vector<std::pair<ShapeKind, ShapeKind>> kinds;
};

const std::vector<KindPairs>& kind_pairs()
{
    using enum ShapeKind;
    static const std::vector<KindPairs> pairs{
        {"spheres and capsules", {{sphere, sphere}, {sphere, capsule}, {capsule, capsule}}},
        {"boxes", {{box, box}}},
        {"round on boxes", {{sphere, box}, {capsule, box}}},
        {"hulls", {{hull, hull}, {hull, box}, {sphere, hull}, {capsule, hull}}},
        {"cylinders and cones",
         {{cylinder, cylinder}, {cylinder, box}, {cone, box}, {cone, cylinder}, {sphere, cylinder}, {sphere, cone}}},
        {"ellipsoids", {{ellipsoid, ellipsoid}, {ellipsoid, box}, {sphere, ellipsoid}}},
        {"half-spaces",
         {{sphere, half_space},
          {box, half_space},
          {hull, half_space},
          {cylinder, half_space},
          {cone, half_space},
          {capsule, half_space},
          {ellipsoid, half_space}}}};
    return pairs;
}

LeagueFamily shape_family(const KindPairs& pairs, league_question question)
{
    const bool deep = question == LEAGUE_DEPTH;
    return {
        fmt::format("{}: {}", name_of(question), pairs.name),
        "shapes",
        question,
        "Shapes at rest, a few ulp apart, nearly parallel, deep, enclosed, of sizes far apart, far from the origin.",
        [kinds = pairs.kinds, question](std::uint64_t seed) {
            const auto [a, b] = kinds[seed % kinds.size()];
            // A depth needs shapes that meet: the next pair that does.
            for (std::uint64_t k = 0;; ++k) {
                const ShapePair pair = draw_shape_pair(a, b, seed + (k << 40));
                LeagueCase asked{.question = question, .a = {pair.a, pair.pose_a}, .b = {pair.b, pair.pose_b}};
                if (question != LEAGUE_DEPTH || k == 20) return asked;
                const SolidTruth solid_a(pair.a, pair.pose_a, pair.pose_b.translation()),
                    solid_b(pair.b, pair.pose_b, pair.pose_b.translation());
                if (gap_of(solid_a, solid_b).upper <= 0) return asked;
            }
        },
        deep                          ? truths::shapes_deep
        : question == LEAGUE_CONTACTS ? truths::contacts
                                      : truths::shapes_apart,
        truths::gap_confirmed};
}

LeagueFamily ground_family(GroundKind ground, league_question question)
{
    return {fmt::format("{}: shapes on a {}", name_of(question), ground_kinds[std::size_t(ground)]),
            "ground",
            question,
            "Shapes of all kinds above, on and in a box as a mesh, a terrain, or the cells of a map.",
            [ground, question](std::uint64_t seed) {
                const ShapeOnGround drawn = draw_shape_on_ground(ShapeKind(seed % 7), ground, seed);
                return LeagueCase{.question = question,
                                  .a = {drawn.ground, drawn.pose_ground, ground == GroundKind::mesh},
                                  .b = {drawn.shape, drawn.pose_shape}};
            },
            truths::shapes_apart,
            truths::gap_confirmed};
}

} // namespace

std::vector<LeagueFamily> shape_league()
{
    std::vector<LeagueFamily> all;
    for (const league_question question : {LEAGUE_MEET, LEAGUE_DISTANCE, LEAGUE_DEPTH, LEAGUE_CONTACTS})
        for (const KindPairs& pairs : kind_pairs()) all.push_back(shape_family(pairs, question));
    for (const league_question question : {LEAGUE_MEET, LEAGUE_DISTANCE})
        for (const GroundKind ground : {GroundKind::mesh, GroundKind::terrain, GroundKind::map})
            all.push_back(ground_family(ground, question));
    return all;
}

} // namespace oncollide::tools
