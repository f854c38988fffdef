#include "verify/trials/hard_trials.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/feature_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "verify/oracle/exact_distance.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using oracle::ExactDistance;

Mesh mesh_of(const TrianglePoints& t)
{
    return make_mesh("triangle", {t[0], t[1], t[2]}, {{0, 1, 2}});
}

/// A World with both triangles.
struct Yard {
    World world;
    ModelId model_a, model_b;
    BodyId a, b;

    Yard(const TwoTriangles& pair, const Settings& settings, const Isometry3d& pose_a = Isometry3d::Identity())
        : world(settings), model_a(world.models().add(mesh_of(pair.first))),
          model_b(world.models().add(mesh_of(pair.second))), a(world.bodies().add({.model = model_a, .pose = pose_a})),
          b(world.bodies().add({.model = model_b}))
    {
    }
    Verdict step()
    {
        const FrameView frame = world.step();
        return frame.pairs.empty() ? Verdict::separate : frame.pairs[0].verdict;
    }
};

class BoundTrial {
public:
    BoundTrial(const TwoTriangles& pair, CaseNumbers draw, Tally& tally)
        : pair_(pair), draw_(draw), tally_(tally), truth_(pair.first, pair.second), meet_(truth_.compare(0) == 0),
          distance_(truth_.value())
    {
    }

    void run()
    {
        ++tally_.cases;
        if (!meet_) try_kernels();
        try_features();
        Yard yard(pair_, {});
        const Finding found = yard.world.pairs().decide(yard.a, yard.b);
        judge(found, 0, "decide()");
        const Distance d = yard.world.pairs().distance(yard.a, yard.b);
        at_most(d.lower, "distance().lower"), at_least(d.upper, "distance().upper");
        try_clearances();
        try_near_features(yard);
        if (!meet_) try_moves(yard, found.bound, d.point_b - d.point_a);
        if (!meet_) try_solids();
    }

private:
    std::string what(const std::string& result, double value) const
    {
        return fmt::format("{} = {:.17g} at distance {:.17g}:{}", result, value, distance_, shown(pair_));
    }
    void at_most(double lower, const std::string& result)
    {
        ++tally_.bounds;
        if (truth_.compare(lower) < 0) tally_.fault(&Tally::broken, what(result, lower));
    }
    void at_least(double upper, const std::string& result)
    {
        ++tally_.bounds;
        if (truth_.compare(upper) > 0) tally_.fault(&Tally::broken, what(result, upper));
    }
    void judge(const Finding& found, double clearance, const std::string& result)
    {
        ++tally_.results;
        const bool in_reach = truth_.compare(clearance) <= 0;
        if (found.verdict == Verdict::separate) {
            if (in_reach) tally_.fault(&Tally::missed, what(result, found.bound));
            at_most(found.bound, result + ", bound");
            if (!meet_ && !(found.bound > 0)) tally_.fault(&Tally::broken, what(result + " has no bound", found.bound));
        } else if (found.verdict == Verdict::colliding) {
            if (!meet_) tally_.fault(&Tally::wrong, what(result + " collides", found.bound));
        } else {
            at_least(found.bound, result + ", bound");
        }
    }

    void try_kernels()
    {
        const auto& [a, b] = pair_;
        const double rounding = usual_rounding(a, b);
        const NearestPoints points = nearest_points(a, b, rounding);
        at_most(std::max(points.distance - rounding, 0.0), "nearest_points() - rounding");
        at_least(points.distance + 2 * rounding, "nearest_points() + rounding");
        const NearestPoints exact = exact_nearest_points(a, b);
        at_most(exact.distance * (1 - 0x1p-44), "exact_nearest_points()");
        at_least(exact.distance * (1 + 0x1p-44), "exact_nearest_points()");
        at_most(triangle_gap(a, b), "triangle_gap()"), at_most(least_possible_gap(a, b), "least_possible_gap()");
    }

    /// An edge and an edge, and a corner and a face.
    void try_features()
    {
        const auto& [a, b] = pair_;
        const double rounding = 0x1p-6 * usual_rounding(a, b) + 0x1p-46 * a[0].cwiseAbs().maxCoeff();
        const auto judge_distance = [&](const ExactDistance& truth, double distance, const char* result) {
            tally_.bounds += 2;
            if (truth.compare(std::max(distance - rounding, 0.0)) < 0 || truth.compare(distance + rounding) > 0)
                tally_.fault(&Tally::broken, what(fmt::format("{} (truly {:.17g})", result, truth.value()), distance));
        };
        const NearestOfSegments edges = nearest_of_segments(a[0], a[1], b[0], b[1], rounding);
        const Vector3d on_a = a[0] + edges.s * (a[1] - a[0]), on_b = b[0] + edges.t * (b[1] - b[0]);
        const ExactDistance between_edges(std::array{a[0], a[1]}, std::array{b[0], b[1]});
        judge_distance(between_edges, edges.distance, "nearest_of_segments()");
        judge_distance(between_edges, (on_a - on_b).norm(), "points of nearest_of_segments()");
        judge_distance(ExactDistance({a[0], a[0], a[0]}, b), (nearest_on(b, a[0], rounding).at - a[0]).norm(),
                       "nearest_on()");
    }

    void try_clearances()
    {
        for (const double clearance : {0.5 * distance_, distance_ * (1 - 0x1p-30), distance_ * (1 + 0x1p-30),
                                       distance_ * (1 + 0x1p-10), 2 * distance_, draw_.magnitude(-30, 0) * size()}) {
            if (!(clearance > 0) || clearance > 1e12) continue;
            const Yard yard(pair_, {.clearance = clearance});
            judge(yard.world.pairs().decide(yard.a, yard.b), clearance,
                  fmt::format("decide() with clearance {:.17g}", clearance));
        }
        const double error = std::max(draw_.magnitude(-3, 3) * distance_, 1e-12);
        if (error > 1e9) return;
        const Yard yard(pair_, {.max_error = error});
        judge(yard.world.pairs().decide(yard.a, yard.b), 0, fmt::format("decide() with error {:.17g}", error));
    }

    void try_near_features(const Yard& yard)
    {
        const double dhat = distance_ * (1 + 0x1p-20);
        if (dhat > 1e12) return;
        Lists<NearFeatures> lists;
        const PairOfBodies both{yard.a, yard.b};
        yard.world.pairs().near_features(std::span(&both, 1), dhat, lists);
        ++tally_.results;
        bool nearest = false;
        for (const NearFeatures& features : lists.items) {
            at_least(features.upper, "near_features(), upper");
            nearest |= truth_.compare(features.lower) >= 0;
        }
        // Surfaces that cross have no features that meet.
        if (!nearest && !meet_) tally_.fault(&Tally::missed, what("near_features() lacks the nearest", dhat));
    }

    /// Moves a, first towards b. The gap that a live World remembers must not change a verdict.
    void try_moves(Yard& live, double gap, Vector3d toward)
    {
        if (!(toward.norm() > 0)) toward = draw_.vector();
        live.step(), live.step();
        for (const double share : {0.5, 0.9, 1.1, draw_.real(0, 4), -0.5}) {
            Isometry3d pose = Isometry3d::Identity();
            const bool by_gap = draw_.number(0, 1);
            pose.translation() = share * (by_gap ? gap : distance_) * toward.normalized() +
                                 draw_.number(0, 1) * draw_.magnitude(-10, 0) * gap * draw_.vector();
            live.world.bodies().set_pose(live.a, pose);
            const Verdict decided = live.world.pairs().decide(live.a, live.b).verdict, stepped = live.step();
            ++tally_.results;
            if (stepped == decided) continue;
            tally_.fault(decided == Verdict::colliding ? &Tally::missed : &Tally::changed,
                         what(fmt::format("step() says {}, decide() {}, moved", name_of(stepped), name_of(decided)),
                              pose.translation().norm()));
        }
        Isometry3d end = Isometry3d::Identity();
        end.translation() = draw_.real(0.5, 3) * distance_ * toward.normalized();
        const MovingModel moving{live.model_a, RigidMotion(Isometry3d::Identity(), end)}, still{live.model_b, {}};
        const double tolerance = std::max(0x1p-10 * distance_, 1e-12);
        const SweepResult swept = live.world.pairs().sweep(moving, still, {.gap_tolerance = tolerance});
        for (const double share : {0.3, 0.999, 1 - 1e-9}) {
            ++tally_.results;
            const Isometry3d pose = moving.motion.pose(share * swept.clear_until);
            if (live.world.pairs().decide(PlacedModel{live.model_a, pose}, live.b).verdict == Verdict::colliding)
                tally_.fault(&Tally::missed, what("sweep(), clear_until", swept.clear_until));
        }
    }
    /// The triangles as faces of two tetrahedra on either side of the gap: a margin above the distance has a region,
    /// whose interval of depths contains the distance.
    void try_solids()
    {
        const auto& [a, b] = pair_;
        const NearestPoints points = exact_nearest_points(a, b);
        const Vector3d across = (points.b - points.a).normalized();
        const auto tetrahedron = [&](const TrianglePoints& t, const Vector3d& back) {
            const double size = (t[1] - t[0]).norm() + (t[2] - t[0]).norm();
            const Vector3d apex = (t[0] + t[1] + t[2]) / 3 + size * (back + 0.2 * draw_.vector());
            return std::array<TrianglePoints, 4>{{t, {t[0], t[1], apex}, {t[1], t[2], apex}, {t[2], t[0], apex}}};
        };
        const auto faces_a = tetrahedron(a, -across), faces_b = tetrahedron(b, across);
        for (const auto& faces : {faces_a, faces_b}) // rounding may have made it flat
            if (const auto& t = faces[0]; orient3d(t[0], t[1], t[2], faces[1][2]) == 0) return;
        ExactDistance truth(a, b);
        for (const TrianglePoints& s : faces_a)
            for (const TrianglePoints& t : faces_b)
                if (ExactDistance other(s, t); other < truth) truth = std::move(other);
        const double distance = truth.value();
        if (distance == 0 || size() > 1e12) return;
        World world;
        const auto add = [&](const std::array<TrianglePoints, 4>& faces) {
            const auto& [t, side, x, y] = faces;
            const bool outward = orient3d(t[0], t[1], t[2], side[2]) < 0;
            const std::vector<Triangle> triangles =
                outward ? std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}}
                        : std::vector<Triangle>{{1, 0, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
            return world.bodies().add(
                {.model = world.models().add(make_mesh("tetrahedron", {t[0], t[1], t[2], side[2]}, triangles))});
        };
        const BodyId first = add(faces_a), second = add(faces_b);
        const Manifold manifold = world.pairs().manifold(first, second, {.margin = distance * (1 + 0x1p-20)});
        // The direction across a tiny gap is rounded, so one tetrahedron may lie inside the other.
        for (const ManifoldRegion& region : manifold.regions)
            if (region.kind == RegionKind::enclosed) return;
        ++tally_.results;
        double most = -std::numeric_limits<double>::infinity();
        for (const ManifoldRegion& region : manifold.regions) {
            ++tally_.bounds;
            most = std::max(most, region.depth_upper);
            if (truth.compare(std::max(-region.depth_lower, 0.0)) > 0)
                tally_.fault(&Tally::broken, what("depth_lower of tetrahedra", region.depth_lower));
        }
        if (manifold.regions.empty())
            tally_.fault(&Tally::missed, what("no region of tetrahedra at distance", distance) + ", apexes" +
                                             shown({faces_a[1], faces_b[1]}));
        else if (most < 0 && truth.compare(-most) < 0)
            tally_.fault(&Tally::broken, what("depth_upper of tetrahedra", most));
    }
    double size() const
    {
        return (pair_.first[1] - pair_.first[0]).norm() + (pair_.second[1] - pair_.second[0]).norm();
    }

    const TwoTriangles& pair_;
    CaseNumbers draw_;
    Tally& tally_;
    const ExactDistance truth_;
    const bool meet_;
    const double distance_;
};

} // namespace

Tally try_bounds(const NearFamily& family, std::uint64_t count, int threads)
{
    return try_many(family.name, count, threads, [&](std::uint64_t number, Tally& tally) {
        const TwoTriangles pair = draw_near(family, number);
        BoundTrial(pair, CaseNumbers(~number), tally).run();
    });
}

} // namespace oncollide::tools
