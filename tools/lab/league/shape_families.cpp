// Two shapes, and shapes on ground.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "league/families.hpp"
#include "truth/convex_truth.hpp"
#include "verify/cases/drawn_shapes.hpp"
#include "verify/oracle/solid_gap.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using oracle::LongVector;
using oracle::SolidTruth;
using Meet = LeagueTruth::Meet;

/// The convex parts whose union a body is, relative to `origin`.
std::vector<SolidTruth> parts_of(const LeagueBody& body, const Vector3d& origin)
{
    std::vector<SolidTruth> parts;
    const auto add = [&](const std::vector<Vector3d>& points) { parts.emplace_back(points, body.pose, origin); };
    if (const auto* shape = std::get_if<Shape>(&body.geometry)) parts.emplace_back(*shape, body.pose, origin);
    if (const auto* map = std::get_if<OccupancyMap>(&body.geometry))
        map->each_box([&](const Aabb& box) {
            std::vector<Vector3d> corners;
            for (int k = 0; k < 8; ++k)
                corners.emplace_back((k & 1 ? box.max : box.min).x(), (k & 2 ? box.max : box.min).y(),
                                     (k & 4 ? box.max : box.min).z());
            add(corners);
        });
    const auto triangles = [&](const Mesh& mesh) {
        for (const auto& [i, j, k] : mesh.triangles) add({mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]});
    };
    if (const auto* terrain = std::get_if<Terrain>(&body.geometry)) triangles(mesh_of(*terrain));
    if (const auto* mesh = std::get_if<Mesh>(&body.geometry)) {
        if (body.solid)
            add(mesh->vertices); // these meshes are convex
        else
            triangles(*mesh);
    }
    return parts;
}

struct Solids {
    Vector3d origin;
    std::vector<SolidTruth> a, b;
};

std::shared_ptr<const Solids> solids_of(const LeagueCase& asked)
{
    const Vector3d origin = asked.b.pose.translation();
    return std::make_shared<const Solids>(Solids{origin, parts_of(asked.a, origin), parts_of(asked.b, origin)});
}

LeagueTruth shape_truth(const LeagueCase& asked)
{
    LeagueTruth truth{.size = asked.a.size() + asked.b.size()};
    for (const LeagueBody* body : {&asked.a, &asked.b})
        truth.coordinate = std::max(truth.coordinate, body->pose.translation().cwiseAbs().maxCoeff() + body->size());
    const auto solids = solids_of(asked);
    oracle::SolidGap least{.lower = std::numeric_limits<long double>::infinity(),
                           .upper = std::numeric_limits<long double>::infinity()};
    for (const SolidTruth& a : solids->a)
        for (const SolidTruth& b : solids->b)
            if (const oracle::SolidGap gap = gap_of(a, b); gap.upper < least.upper) least = gap;
    truth.lower = least.lower, truth.upper = least.upper;
    truth.gap = least.lower;
    const long double rounding = 1e-15L * truth.size + 1e-18L * truth.coordinate;
    truth.meet = least.lower > rounding ? Meet::no : least.upper <= rounding ? Meet::yes : Meet::open;
    const LongVector up = asked.a.pose.linear().col(2).cast<long double>().normalized();
    const bool simple = solids->a.size() == 1 && solids->b.size() == 1;
    if (truth.meet == Meet::yes && simple) {
        const oracle::LeastWidth width =
            least_width(solids->a[0], solids->b[0], gap_of(solids->a[0], solids->b[0]), up);
        truth.gap = -width.width;
    } else if (truth.meet == Meet::yes) {
        truth.gap = 0; // how deep is not known: touching and deep count alike
        truth.meet = Meet::open;
        for (const SolidTruth& a : solids->a) // deep in one part is deep
            for (const SolidTruth& b : solids->b)
                if (gap_of(a, b).upper <= rounding) {
                    const oracle::LeastWidth width = least_width(a, b, gap_of(a, b), up);
                    truth.gap = std::min(truth.gap, -width.width), truth.meet = Meet::yes;
                }
    }
    if (asked.question == LEAGUE_DISTANCE && std::holds_alternative<Shape>(asked.a.geometry))
        truth.off_surface = [solids](const Vector3d& point, int of) {
            const SolidTruth& solid = of ? solids->b[0] : solids->a[0];
            return std::abs(solid.from_surface((point.cast<long double>() - solids->origin.cast<long double>())));
        };
    return truth;
}

/// By another GJK, in other arithmetic, on the geometries themselves: whether they are apart, and how far.
bool gap_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    const auto is_half_space = [](const LeagueBody& body) {
        const auto* shape = std::get_if<Shape>(&body.geometry);
        return shape && std::holds_alternative<HalfSpace>(*shape);
    };
    if (is_half_space(asked.a) || is_half_space(asked.b)) return true;
    const auto sets = [](const LeagueBody& body) { return convex_sets(body.geometry, body.pose); };
    const TrueDistance distance = true_distance(sets(asked.a), sets(asked.b));
    const long double rounding = 1e-12L * truth.size + 1e-15L * truth.coordinate;
    const long double lower = truth.meet == Meet::no ? std::max(truth.gap, 0.0L) : 0;
    if (asked.a.solid) return true; // its inside is no set of triangles
    return distance.upper >= lower - rounding && (truth.meet == Meet::no || distance.lower <= rounding);
}

/// Depths are judged where the least translation is known exactly.
LeagueTruth depth_truth(const LeagueCase& asked)
{
    LeagueTruth truth = shape_truth(asked);
    truth.lower = 0, truth.upper = std::max(-truth.gap, 0.0L);
    if (truth.meet != Meet::yes || !(truth.gap < 0)) return truth;
    truth.lower = truth.upper = -truth.gap;
    const auto solids = solids_of(asked);
    const SolidTruth &a = solids->a[0], &b = solids->b[0];
    const bool known = a.is_half_space() || b.is_half_space() || (a.has_flat_core() && b.has_flat_core());
    if (!known) truth.lower = 0; // the least width that was found is an upper bound
    truth.way_out = [solids](const Vector3d& unit) {
        return width_along(solids->a[0], solids->b[0], unit.cast<long double>());
    };
    return truth;
}

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
    const bool depth = question == LEAGUE_DEPTH;
    return {
        fmt::format("{}: {}", name_of(question), pairs.name),
        "shapes",
        question,
        "Shapes at rest, a few ulp apart, nearly parallel, deep, enclosed, of sizes far apart, far from the origin.",
        [kinds = pairs.kinds, question](std::uint64_t seed) {
            const auto [a, b] = kinds[seed % kinds.size()];
            // Depth is asked of shapes that meet: the next one that does.
            for (std::uint64_t k = 0;; ++k) {
                const ShapePair pair = draw_shape_pair(a, b, seed + (k << 40));
                LeagueCase asked{.question = question, .a = {pair.a, pair.pose_a}, .b = {pair.b, pair.pose_b}};
                if (question != LEAGUE_DEPTH || k == 20) return asked;
                const SolidTruth solid_a(pair.a, pair.pose_a, pair.pose_b.translation()),
                    solid_b(pair.b, pair.pose_b, pair.pose_b.translation());
                if (gap_of(solid_a, solid_b).upper <= 0) return asked;
            }
        },
        depth ? depth_truth : shape_truth};
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
            shape_truth,
            gap_confirmed};
}

} // namespace

std::vector<LeagueFamily> shape_league()
{
    std::vector<LeagueFamily> all;
    for (const league_question question : {LEAGUE_MEET, LEAGUE_DISTANCE, LEAGUE_DEPTH})
        for (const KindPairs& pairs : kind_pairs()) all.push_back(shape_family(pairs, question));
    for (const league_question question : {LEAGUE_MEET, LEAGUE_DISTANCE})
        for (const GroundKind ground : {GroundKind::mesh, GroundKind::terrain, GroundKind::map})
            all.push_back(ground_family(ground, question));
    return all;
}

} // namespace oncollide::tools
