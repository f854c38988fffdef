// Pairs of meshes that touch at vertices with hundreds of triangles each: n^2 pairs of triangles touch.
#include <cmath>
#include <ctime>
#include <numbers>

#include <gtest/gtest.h>

#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Drum {
    double bottom, top;               ///< of the rim
    double middle_bottom, middle_top; ///< of the caps' centre vertices: a cone if they differ from the rim's
    double radius = 1, dent = 1;      ///< every second corner of the rim is at `dent` times the radius
    double phase = 0;                 ///< in corners
    Vector3d centre = Vector3d::Zero();
};

/// Two fans of n triangles, and a wall between them.
Mesh drum(std::uint32_t n, const Drum& d, const Matrix3d& rotation = Matrix3d::Identity())
{
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (const auto& [z, middle] : {std::pair(d.bottom, d.middle_bottom), std::pair(d.top, d.middle_top)}) {
        vertices.push_back(rotation * (d.centre + Vector3d(0, 0, middle)));
        for (std::uint32_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * (i + d.phase) / n, r = d.radius * (i % 2 ? d.dent : 1);
            vertices.push_back(rotation * (d.centre + Vector3d(r * std::cos(angle), r * std::sin(angle), z)));
        }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t low = 1 + i, next = 1 + (i + 1) % n, up = n + 1;
        triangles.push_back({0, next, low}), triangles.push_back({up, up + low, up + next});
        triangles.push_back({low, next, up + next}), triangles.push_back({low, up + next, up + low});
    }
    return make_mesh("drum", std::move(vertices), std::move(triangles));
}

const Matrix3d rotated = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();

struct Outcome {
    ContactKind kind;
    double ms;
    std::uint64_t rows; ///< comparisons of boxes
};

Outcome check(const Mesh& a, const Mesh& b)
{
    Scene scene;
    scene.add_body({.name = "a", .geometry = scene.add("a", a)});
    scene.add_body({.name = "b", .geometry = scene.add("b", b)});
    Settings settings;
    settings.exact = ExactLevel::predicates, settings.contact_kinds = true;
    Pipeline pipeline(scene, settings);
    const std::clock_t start = std::clock(); // CPU time, independent of the machine's load
    const FrameView frame = pipeline.step(scene);
    const double ms = 1e3 * double(std::clock() - start) / CLOCKS_PER_SEC;
    return {frame.pairs.empty() ? ContactKind::unknown : frame.pairs[0].kind, ms, frame.trees.node_pairs};
}

constexpr std::uint32_t segments = 512;
const Drum lower{-1, 0, -1, 0}, upper{0, 1, 0, 1};

/// Exactly coplanar contacts take a few milliseconds; the limit is ten times that, for a busy machine.
void expect_quick(const Mesh& a, const Mesh& b, ContactKind kind, double most_ms)
{
    const Outcome outcome = check(a, b), swapped = check(b, a);
    EXPECT_EQ(outcome.kind, kind);
    EXPECT_EQ(swapped.kind, kind);
    double least = std::min(outcome.ms, swapped.ms);
    for (int more = 0; more < 4 && least >= most_ms; ++more) least = std::min(least, check(a, b).ms);
    EXPECT_LT(least, most_ms);
}

/// The plane between the meshes is found before most of the n^2 pairs.
void expect_few_pairs(const Mesh& a, const Mesh& b)
{
    expect_quick(a, b, ContactKind::touching, 100);
    EXPECT_LT(std::max(check(a, b).rows, check(b, a).rows), 20 * segments);
}

TEST(FanContact, StackedCylindersTakeMilliseconds)
{
    expect_few_pairs(drum(segments, lower), drum(segments, upper));
    for (const double radius : {0.1, 1.0}) { // walls of slender drums touch first
        Drum a = lower, b = upper;
        a.radius = b.radius = radius;
        for (const double phase : {0.0, 0.37})
            for (const Vector3d& centre : {Vector3d(0, 0, 0), Vector3d(0.3 * radius, 0.11 * radius, 0)}) {
                SCOPED_TRACE(testing::Message() << radius << ' ' << phase << ' ' << centre.x());
                b.phase = phase, b.centre = centre;
                expect_few_pairs(drum(segments, a), drum(segments, b));
            }
    }
}

TEST(FanContact, StackedCylindersAtAnyAngleDoNotTakeSeconds)
{
    // The caps' corners are the same, but not coplanar.
    expect_quick(drum(segments, lower, rotated), drum(segments, upper, rotated), ContactKind::touching, 1500);
}

TEST(FanContact, ConesThatTouchInAPointDoNotTakeSeconds)
{
    const Drum low{-1, -0.5, -1, 0}, high{0.5, 1, 0, 1};
    expect_quick(drum(segments, low), drum(segments, high), ContactKind::touching, 500);
    expect_quick(drum(segments, low, rotated), drum(segments, high, rotated), ContactKind::touching, 500);
    Drum star = low, other = high;
    star.dent = other.dent = 0.5, other.phase = 0.3;
    expect_quick(drum(segments, star), drum(segments, other), ContactKind::touching, 500);
    expect_quick(drum(segments, star, rotated), drum(segments, other, rotated), ContactKind::touching, 500);
}

TEST(FanContact, CoaxialGearsTakeMilliseconds)
{
    Drum low = lower, high = upper;
    low.dent = high.dent = 0.9, high.phase = 0.5;
    expect_few_pairs(drum(segments, low), drum(segments, high));
}

/// A cone in the dent of another cone that is hollowed from above: they touch only at the apex.
TEST(FanContact, ACornerInsideACornerCrosses)
{
    const Drum cup{0.25, -1, 0, -1}, outer{1, 2, 0, 2}, inner{2, 2.5, 0, 2.5, 0.5};
    // A dent above z = 0 of slope 0.25: the cone of slope 2 is inside it, outside of the cup's body.
    expect_quick(drum(64, cup), drum(64, inner), ContactKind::touching, 500);
    // One cone inside another: their surfaces meet only at the apex, but their insides overlap.
    const Drum narrow{0.75, 0.9, 0, 0.9, 0.25};
    expect_quick(drum(64, outer), drum(64, narrow), ContactKind::crossing, 500);
    expect_quick(drum(64, outer, rotated), drum(64, narrow, rotated), ContactKind::crossing, 500);
}

} // namespace
} // namespace oncollide
