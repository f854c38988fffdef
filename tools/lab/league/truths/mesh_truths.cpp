// Truths in integers and rational arithmetic: triangles, meshes, rays, boxes.
#include <algorithm>

#include "league/truths/truths.hpp"
#include "render/drawn_mesh.hpp"
#include "truth/exact_oracle.hpp"
#include "truth/triangle_distance.hpp"
#include "truth/truth.hpp"
#include "verify/oracle/exact_distance.hpp"
#include "verify/oracle/segment_truth.hpp"

namespace oncollide::tools::truths {
namespace {

using Eigen::Vector3d;
using Meet = LeagueTruth::Meet;

TrianglePoints triangle_of(const LeagueBody& body)
{
    const auto& v = std::get<Mesh>(body.geometry).vertices;
    return {v[0], v[1], v[2]};
}

LeagueTruth truth_about(const LeagueCase& asked)
{
    LeagueTruth truth{.size = asked.a.size() + asked.b.size()};
    for (const LeagueBody* body : {&asked.a, &asked.b}) {
        const Aabb box = bounds_of(body->geometry);
        truth.coordinate = std::max({truth.coordinate, box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff()});
    }
    return truth;
}

std::vector<Aabb> boxes_of(const OccupancyMap& map)
{
    std::vector<Aabb> boxes;
    map.each_box([&](const Aabb& box) { boxes.push_back(box); });
    return boxes;
}

} // namespace

LeagueTruth triangles_meet(const LeagueCase& asked)
{
    LeagueTruth truth = truth_about(asked);
    truth.exact = true;
    truth.meet =
        oracle::contact(triangle_of(asked.a), triangle_of(asked.b)) != TriangleContact::separate ? Meet::yes : Meet::no;
    return truth;
}

bool meeting_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    return (oracle::ExactDistance(triangle_of(asked.a), triangle_of(asked.b)).compare(0) == 0) ==
           (truth.meet == Meet::yes);
}

LeagueTruth triangles_apart(const LeagueCase& asked)
{
    LeagueTruth truth = truth_about(asked);
    const TrianglePoints a = triangle_of(asked.a), b = triangle_of(asked.b);
    const oracle::ExactDistance distance(a, b);
    truth.lower = truth.upper = truth.gap = distance.value();
    truth.meet = distance.compare(0) == 0 ? Meet::yes : Meet::no;
    truth.off_surface = [a, b](const Vector3d& point, int of) {
        return oracle::ExactDistance({point, point, point}, of ? b : a).value();
    };
    return truth;
}

bool distance_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    const TrianglePoints a = triangle_of(asked.a), b = triangle_of(asked.b);
    const auto wide = [](const TrianglePoints& t) {
        return TriangleL{t[0].cast<long double>(), t[1].cast<long double>(), t[2].cast<long double>()};
    };
    const DistanceRange range = triangle_distance(wide(a), wide(b));
    const long double rounding = 1e-17L * truth.coordinate;
    return (oracle::contact(a, b) != TriangleContact::separate) == (truth.meet == Meet::yes) &&
           range.low <= truth.upper + rounding && range.high >= truth.lower - rounding;
}

LeagueTruth meshes_meet(const LeagueCase& asked)
{
    LeagueTruth truth = truth_about(asked);
    truth.exact = true;
    const TruthModel a(asked.a.geometry, asked.a.solid), b(asked.b.geometry, asked.b.solid);
    const PairTruth found =
        truth_of(a, asked.a.pose, b, asked.b.pose, {.kinds = false, .deep = false, .distance = false});
    truth.meet = found.collide || (asked.a.solid && found.enclosed) ? Meet::yes : Meet::no;
    return truth;
}

bool meshes_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    if (asked.a.solid) return true;
    const TruthModel a(std::get<Mesh>(asked.a.geometry), false), b(std::get<Mesh>(asked.b.geometry), false);
    const DistanceTruth distance = surface_distance(a.halved(), asked.a.pose, b.halved(), asked.b.pose);
    const double rounding = 1e-15 * distance.size;
    return truth.meet == Meet::yes ? distance.low <= rounding : distance.high > 0;
}

LeagueTruth first_hit(const LeagueCase& asked)
{
    LeagueTruth truth{.way = asked.motion.cast<long double>().norm(), .size = asked.a.size()};
    truth.exact = true;
    const Aabb bounds = bounds_of(asked.a.geometry);
    truth.coordinate = std::max({bounds.min.cwiseAbs().maxCoeff(), bounds.max.cwiseAbs().maxCoeff(),
                                 asked.from.cwiseAbs().maxCoeff() + asked.motion.cwiseAbs().maxCoeff()});
    const auto* mesh = std::get_if<Mesh>(&asked.a.geometry);
    const std::vector<Aabb> boxes = mesh ? std::vector<Aabb>{} : boxes_of(std::get<OccupancyMap>(asked.a.geometry));
    oracle::SegmentTruth found;
    const Segment segment{asked.from, asked.from + asked.motion};
    for (std::uint32_t t = 0; mesh && t < mesh->triangles.size(); ++t) found.add(segment, corners_of(*mesh, t));
    for (const Aabb& box : boxes) found.add(segment, box);
    truth.meet = found.met() ? Meet::yes : Meet::no;
    if (!found.met()) return truth;
    double low = 0, high = 1;
    while (high - low > 1e-12) {
        const double middle = (low + high) / 2;
        (found.within(0, middle) ? high : low) = middle;
    }
    truth.lower = found.within(0, 0) ? 0 : low, truth.upper = high;
    return truth;
}

bool hit_confirmed(const LeagueCase& asked, const LeagueTruth& truth)
{
    const Vector3d to = asked.from + asked.motion;
    const auto meets = [&](const Mesh& mesh) {
        bool met = false;
        for (std::uint32_t t = 0; t < mesh.triangles.size() && !met; ++t)
            met = oracle::contact({asked.from, to, to}, corners_of(mesh, t)) != TriangleContact::separate;
        return met;
    };
    if (const auto* mesh = std::get_if<Mesh>(&asked.a.geometry)) return meets(*mesh) == (truth.meet == Meet::yes);
    const std::vector<Aabb> boxes = boxes_of(std::get<OccupancyMap>(asked.a.geometry));
    const bool inside = std::ranges::any_of(boxes, [&](const Aabb& box) {
        return (box.min.array() <= asked.from.array()).all() && (asked.from.array() <= box.max.array()).all();
    });
    return (inside || meets(mesh_of_boxes("cells", boxes))) == (truth.meet == Meet::yes);
}

LeagueTruth overlapping(const LeagueCase& asked)
{
    LeagueTruth truth;
    const auto& bodies = asked.bodies;
    for (std::uint32_t a = 0; a < bodies.size(); ++a)
        for (std::uint32_t b = a + 1; b < bodies.size(); ++b) {
            const auto half = [&](std::uint32_t k) { return std::get<Box>(std::get<Shape>(bodies[k].geometry)).half; };
            const Vector3d apart =
                (bodies[a].pose.translation() - bodies[b].pose.translation()).cwiseAbs() - half(a) - half(b);
            if (apart.maxCoeff() <= 0) truth.pairs.emplace_back(a, b);
        }
    return truth;
}

} // namespace oncollide::tools::truths
