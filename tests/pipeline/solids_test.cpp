// Shapes, meshes and maps against one another, held against bounds on their distance that share no code with the
// library.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <sstream>

#include <octomap/OcTree.h>

#include "hard/convex_truth.hpp"
#include "random_pose.hpp"

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>

namespace oncollide {
namespace {

using tools::convex_sets;
using tools::true_distance;

/// Draws small geometries and poses: on a grid of 1/8, where touching is common, or anywhere.
class Draw {
public:
    explicit Draw(std::uint64_t seed) : random_(seed), on_grid_(seed % 4 != 0) {}

    int number(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
    double length()
    {
        return on_grid_ ? 0.125 * number(1, 12) : std::uniform_real_distribution<double>(0.1, 1.5)(random_);
    }
    double coordinate()
    {
        return on_grid_ ? 0.125 * number(-10, 10) : std::uniform_real_distribution<double>(-1.3, 1.3)(random_);
    }
    Eigen::Vector3d point()
    {
        const double x = coordinate(), y = coordinate(), z = coordinate();
        return {x, y, z};
    }
    Eigen::Vector3d lengths()
    {
        const double x = length(), y = length(), z = length();
        return {x, y, z};
    }
    Eigen::Isometry3d pose()
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = 2 * point();
        if (!on_grid_ && number(0, 1))
            pose.linear() = random_pose(random_(), 1).linear();
        else // one of the 24 turns of a cube
            for (int turns = number(0, 5); turns > 0; --turns) {
                const int axis = number(0, 2);
                Eigen::Matrix3d quarter = Eigen::Matrix3d::Zero();
                quarter(axis, axis) = 1, quarter((axis + 1) % 3, (axis + 2) % 3) = -1;
                quarter((axis + 2) % 3, (axis + 1) % 3) = 1;
                pose.linear() = (quarter * pose.linear()).eval();
            }
        return pose;
    }
    GeometryData geometry()
    {
        switch (number(0, 8)) {
        case 0:
            return Shape(Sphere{length()});
        case 1:
            return Shape(Box{lengths()});
        case 2:
            return Shape(Capsule{length(), number(0, 4) ? length() : 0});
        case 3:
            return Shape(Cylinder{length(), length()});
        case 4:
            return make_box_mesh(lengths());
        case 5:
            return triangles();
        case 6:
            return map();
        default:
            return hull();
        }
    }

private:
    GeometryData triangles()
    {
        std::vector<Eigen::Vector3d> vertices;
        std::vector<Triangle> faces;
        for (std::uint32_t k = 0, count = std::uint32_t(number(1, 5)); k < count; ++k) {
            for (int i = 0; i < 3; ++i) vertices.push_back(point());
            faces.push_back({3 * k, 3 * k + 1, number(0, 9) ? 3 * k + 2 : 3 * k}); // some without area
        }
        return make_mesh("triangles", vertices, faces);
    }
    GeometryData map()
    {
        octomap::OcTree tree(on_grid_ ? 0.25 : 0.3);
        for (int k = number(1, 12); k > 0; --k) {
            const Eigen::Vector3d p = point();
            tree.updateNode(octomap::point3d(float(p.x()), float(p.y()), float(p.z())), true);
        }
        if (number(0, 3) == 0) // cells that octrees join to a larger one
            for (int k = 0; k < 8; ++k)
                tree.updateNode(
                    octomap::point3d(float(k & 1 ? 0.1 : 0.4), float(k & 2 ? 0.1 : 0.4), float(k & 4 ? 0.1 : 0.4)),
                    true);
        tree.prune();
        return make_occupancy_map(tree);
    }
    GeometryData hull()
    {
        while (true) {
            ConvexHull hull;
            if (number(0, 2) == 0) {
                const Eigen::Vector3d half = lengths();
                for (int k = 0; k < 8; ++k)
                    hull.points.push_back(
                        half.cwiseProduct(Eigen::Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
            }
            for (int k = number(4, 12); k > 0; --k) hull.points.push_back(point());
            try {
                check_shape("hull", hull);
                return Shape(hull);
            } catch (const Error&) { // flat
            }
        }
    }

    std::mt19937_64 random_;
    bool on_grid_;
};

bool is_round(const GeometryData& geometry)
{
    const auto* shape = std::get_if<Shape>(&geometry);
    return shape && (std::holds_alternative<Sphere>(*shape) || std::holds_alternative<Capsule>(*shape) ||
                     std::holds_alternative<Cylinder>(*shape));
}

struct Body {
    GeometryData geometry;
    Eigen::Isometry3d pose;
};

/// For messages: what to make by hand.
std::string text_of(const Body& body)
{
    std::ostringstream text;
    text.precision(17);
    if (const auto* shape = std::get_if<Shape>(&body.geometry)) {
        text << "shape " << shape->index() << " in " << bounds_of(*shape).max.transpose();
        if (const auto* hull = std::get_if<ConvexHull>(shape))
            for (const Eigen::Vector3d& p : hull->points) text << "; " << p.transpose();
    } else if (const auto* mesh = std::get_if<Mesh>(&body.geometry)) {
        text << "mesh";
        for (const Triangle& t : mesh->triangles)
            for (const std::uint32_t v : t) text << "; " << mesh->vertices[v].transpose();
    } else {
        text << "map";
        for (const Aabb& cell : std::get<OccupancyMap>(body.geometry).cells)
            text << "; " << cell.min.transpose() << " to " << cell.max.transpose();
    }
    text << "\npose\n" << body.pose.matrix();
    return text.str();
}

PairResult result_of(const Settings& settings, const Body& a, const Body& b)
{
    World world(settings);
    for (const Body* body : {&a, &b})
        world.add_body(
            {.model = std::visit([&](const auto& g) { return world.add(g); }, body->geometry), .pose = body->pose});
    const FrameView frame = world.step();
    PairResult apart{};
    apart.verdict = Verdict::separate;
    if (frame.pairs.empty()) return apart;
    return frame.pairs[0];
}

long long scenes_to_draw()
{
    const char* more = std::getenv("ONCOLLIDE_SCENES");
    return more ? std::atoll(more) : 4000;
}

TEST(ConvexSolids, AgreeWithTheTruthAboutConvexSets)
{
    constexpr double tie = 1e-11;
    std::map<Verdict, int> seen;
    int unsure = 0;
    for (long long seed = 1; seed <= scenes_to_draw(); ++seed) {
        Draw draw{std::uint64_t(seed)};
        const Body a{draw.geometry(), draw.pose()}, b{draw.geometry(), draw.pose()};
        const auto truth = true_distance(convex_sets(a.geometry, a.pose), convex_sets(b.geometry, b.pose));
        const double clearance = draw.number(0, 3) ? 0 : draw.length();
        for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl}) {
            const Settings settings{.depth = 4, .clearance = clearance, .exact = exact};
            const PairResult result = result_of(settings, a, b), swapped = result_of(settings, b, a);
            SCOPED_TRACE(testing::Message() << text_of(a) << "\n" << text_of(b) << "\nseed " << seed << ", " << a.geometry.index() << " and " << b.geometry.index() << ", exact "
                         << name_of(exact) << ", clearance " << clearance << ", distance " << double(truth.lower)
                         << " to " << double(truth.upper) << ", " << name_of(result.verdict) << " " << result.bound);
            for (const PairResult& r : {result, swapped}) {
                if (r.verdict == Verdict::separate) {
                    ASSERT_GE(truth.upper, r.bound - tie);
                }
                if (r.verdict == Verdict::separate) {
                    ASSERT_GE(truth.upper, clearance - tie);
                }
                if (r.verdict == Verdict::colliding) {
                    ASSERT_LE(truth.lower, tie);
                }
                if (r.verdict == Verdict::within || r.verdict == Verdict::undecided) {
                    ASSERT_LE(truth.lower, r.bound + tie);
                }
            }
            if (exact != ExactLevel::predicates) continue;
            ++seen[result.verdict];
            unsure += result.verdict == Verdict::within && clearance == 0;
            ASSERT_EQ(result.verdict, swapped.verdict);
            const bool rounds = is_round(a.geometry) || is_round(b.geometry);
            if (clearance > 0 || (truth.upper > 0 && truth.lower < 1e-4)) continue;
            // Far from a tie exact tests decide; without round shapes always.
            ASSERT_EQ(result.verdict, truth.upper > 0                               ? Verdict::separate
                                      : rounds && result.verdict == Verdict::within ? Verdict::within
                                                                                    : Verdict::colliding);
        }
    }
    EXPECT_GT(seen[Verdict::separate], 100);
    EXPECT_GT(seen[Verdict::colliding], 100);
    RecordProperty("within", unsure);
    std::printf("%d separate, %d colliding, %d within without a clearance\n", seen[Verdict::separate],
                seen[Verdict::colliding], unsure);
}

TEST(ConvexSolids, AHullAndAMeshThatFclParts)
{
    const Body hull{Shape(ConvexHull{[] {
                        std::vector<Eigen::Vector3d> points;
                        for (int k = 0; k < 8; ++k)
                            points.emplace_back(k & 1 ? 0.75 : -0.75, k & 2 ? 0.5 : -0.5, k & 4 ? 1.5 : -1.5);
                        return points;
                    }()}),
                    Eigen::Isometry3d(Eigen::Translation3d(2.5, -1.5, 1.5))};
    const Body mesh{make_box_mesh({0.25, 0.75, 0.25}), Eigen::Isometry3d(Eigen::Translation3d(3, -1, 3))};
    for (const Mode mode : {Mode::surface, Mode::solid}) {
        EXPECT_EQ(result_of({.exact = ExactLevel::predicates, .mode = mode}, hull, mesh).verdict, Verdict::colliding);
        EXPECT_NE(result_of({.exact = ExactLevel::fcl, .mode = mode}, hull, mesh).verdict, Verdict::separate);
    }
}

TEST(ConvexSolids, BoxesWhoseDistanceFclOverstates)
{
    const Body a{Shape(Box{{0.25, 1.25, 1}}), Eigen::Isometry3d(Eigen::Translation3d(0, -4.5, -2))};
    const Body b{Shape(Box{{1, 1, 0.75}}), Eigen::Isometry3d(Eigen::Translation3d(1.5, -4.5, -4))};
    for (const ExactLevel exact : {ExactLevel::predicates, ExactLevel::fcl}) {
        const PairResult result = result_of({.clearance = 2, .exact = exact}, a, b);
        EXPECT_NE(result.verdict, Verdict::separate);
        EXPECT_GE(result.bound, 0.3535);
    }
    EXPECT_NEAR(result_of({.clearance = 2, .exact = ExactLevel::predicates}, a, b).bound, 0.3536, 1e-4);
}

} // namespace
} // namespace oncollide
