#include <oncollide/narrowphase/gl/walk/self_test.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::gl::walk {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A closed surface with waves on it.
Mesh wavy_ball()
{
    constexpr int around = 12, rows = 7;
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (int i = 0; i <= rows; ++i)
        for (int k = 0; k < around; ++k) {
            const double u = std::numbers::pi * (i + 0.01) / (rows + 0.02), v = 2 * std::numbers::pi * k / around;
            const double r = 1 + 0.2 * std::sin(3 * v + i);
            vertices.push_back({r * std::sin(u) * std::cos(v), r * std::sin(u) * std::sin(v), 1.3 * r * std::cos(u)});
        }
    const auto at = [&](int i, int k) { return static_cast<std::uint32_t>(i * around + k % around); };
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < around; ++k) {
            triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
            triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
        }
    return make_mesh("wavy ball", std::move(vertices), std::move(triangles));
}

Mesh box()
{
    std::vector<Vector3d> vertices;
    for (int i = 0; i < 8; ++i) vertices.push_back({i & 1 ? 0.7 : -0.7, i & 2 ? 0.7 : -0.7, i & 4 ? 0.7 : -0.7});
    return make_mesh("box", std::move(vertices),
                     {{0, 2, 3},
                      {0, 3, 1},
                      {4, 5, 7},
                      {4, 7, 6},
                      {0, 1, 5},
                      {0, 5, 4},
                      {2, 6, 7},
                      {2, 7, 3},
                      {0, 4, 6},
                      {0, 6, 2},
                      {1, 3, 7},
                      {1, 7, 5}});
}

struct Case {
    const ObbTree *a, *b;
    Isometry3d pose_a, pose_b;
};

std::vector<Case> cases(const ObbTree& ball, const ObbTree& box)
{
    std::vector<Case> all;
    const auto pose = [](double angle, const Vector3d& axis, const Vector3d& at) {
        return Isometry3d(Eigen::Translation3d(at) * Eigen::AngleAxisd(angle, axis.normalized()));
    };
    for (int i = 0; i < 24; ++i) {
        const double away = 0.8 + 0.1 * i;
        all.push_back({&ball, &ball, pose(0.7 * i, {1, 0.3 * i, 2}, {100, -50.0 * i, 3}),
                       pose(1.1 * i, {0.2 * i, 1, -1}, Vector3d(100, -50.0 * i, 3) + away * Vector3d(0.6, 0, 0.8))});
    }
    for (const double gap : {1e-9, -1e-9, 1e-3, -1e-3})
        all.push_back({&box, &box, Isometry3d::Identity(), pose(0.3, {1, 0, 0}, {1.4 + gap, 0.1, 0.2})});
    all.push_back({&box, &ball, pose(0.5, {1, 1, 0}, {0.5, 0, 0}), Isometry3d::Identity()});
    all.push_back({&ball, &ball, Isometry3d::Identity(), pose(0.5, {1, 1, 0}, {9, 9, 9})});
    return all;
}

/// The triangles of a case in A's frame, as exact decisions see them.
struct Placed {
    const Case& of;
    RelativePose b_to_a;

    explicit Placed(const Case& c) : of(c), b_to_a(c.pose_a, c.pose_b) {}
    TrianglePoints a(std::uint32_t i) const { return of.a->corners(i); }
    TrianglePoints b(std::uint32_t i) const
    {
        TrianglePoints t = of.b->corners(i);
        for (Vector3d& p : t) p = b_to_a(p);
        return t;
    }
};

/// False if boxes around two triangles are this far apart.
bool may_be_nearer(const TrianglePoints& a, const TrianglePoints& b, double distance)
{
    Vector3d gap = Vector3d::Zero();
    for (int i = 0; i < 3; ++i)
        gap[i] = std::max({0.0, std::min({b[0][i], b[1][i], b[2][i]}) - std::max({a[0][i], a[1][i], a[2][i]}),
                           std::min({a[0][i], a[1][i], a[2][i]}) - std::max({b[0][i], b[1][i], b[2][i]})});
    return gap.squaredNorm() < distance * distance;
}

/// The fault of a result; empty: it is right.
std::string fault_of(const Placed& placed, const MeshWalkResult& result, std::span<const UnsureTriangles> unsure)
{
    const std::size_t of_a = placed.of.a->mesh().triangles.size(), of_b = placed.of.b->mesh().triangles.size();
    if (result.verdict() == MeshWalkVerdict::open) return "it is open";
    if (result.verdict() == MeshWalkVerdict::meets) {
        if (result.a >= of_a || result.b >= of_b) return "the triangles that meet do not exist";
        return triangles_meet(placed.a(result.a), placed.b(result.b)) ? "" : "it meets by triangles that are apart";
    }
    for (std::uint32_t i = 0; i < of_a; ++i)
        for (std::uint32_t k = 0; k < of_b; ++k) {
            const TrianglePoints a = placed.a(i), b = placed.b(k);
            const bool listed =
                std::ranges::any_of(unsure, [&](const UnsureTriangles& pair) { return pair.a == i && pair.b == k; });
            if (listed) continue;
            if (triangles_meet(a, b)) return "triangles that meet are missing";
            if (may_be_nearer(a, b, double(result.bound)) &&
                triangle_distance(a, b) + usual_rounding(a, b) < double(result.bound))
                return "the bound of the distance is too large";
        }
    return "";
}

} // namespace

std::string fault_of(MeshWalks& walks)
{
    const Mesh ball_mesh = wavy_ball(), box_mesh = box();
    ObbTree ball_tree(ball_mesh), box_tree(box_mesh);
    for (ObbTree* tree : {&ball_tree, &box_tree}) tree->grow_in(tree->bounds(), ObbTree::leaf_triangles);
    const std::vector<Case> all = cases(ball_tree, box_tree);
    const std::span<MeshWalkPair> pairs = walks.begin(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        const auto a = walks.hold(*all[i].a, 0), b = walks.hold(*all[i].b, 0);
        if (!a || !b) return "there is no room for two small meshes";
        pairs[i] = {RelativePose(all[i].pose_a, all[i].pose_b), *a, *b};
    }
    walks.submit(false);
    const std::span<const MeshWalkResult> results = walks.collect();
    std::size_t met = 0;
    std::vector<UnsureTriangles> unsure;
    for (std::size_t i = 0; i < all.size(); ++i) {
        unsure.clear();
        for (const UnsureTriangles& pair : walks.unsure())
            if (pair.pair == i) unsure.push_back(pair);
        if (unsure.size() > 8) return fmt::format("pair {}: {} pairs of triangles are not certain", i, unsure.size());
        if (const std::string fault = fault_of(Placed(all[i]), results[i], unsure); !fault.empty())
            return fmt::format("pair {}: {}", i, fault);
        met += results[i].verdict() == MeshWalkVerdict::meets;
    }
    walks.drop_unused(1);
    if (met == 0 || met == all.size()) return fmt::format("{} of {} pairs meet", met, all.size());
    return "";
}

} // namespace oncollide::gl::walk
