#include <oncollide/scenes/model/convex_hull.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>

#include <Eigen/Geometry>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/system_file.hpp>
#include <oncollide/scenes/model/hull_slack.hpp>

namespace oncollide {

namespace {

/// One run of Qhull. Qhull reports errors by longjmp inside qh_new_qhull, which returns a code; nothing called after it
/// can fail. Its output goes to the null device.
class Qhull {
public:
    Qhull(std::vector<double>& coordinates, const char* options) : quiet_(std::fopen(null_device, "w"), &std::fclose)
    {
        if (!quiet_) return;
        std::string command = options; // Qhull keeps a copy
        qh_zero(&qh_, quiet_.get());
        started_ = true;
        const int failed = qh_new_qhull(&qh_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False,
                                        command.data(), nullptr, quiet_.get());
        good_ = failed == qh_ERRnone;
        flat_ = failed == qh_ERRsingular;
    }
    ~Qhull()
    {
        if (!started_) return;
        qh_freeqhull(&qh_, !qh_ALL);
        int long_left = 0, bytes_left = 0;
        qh_memfreeshort(&qh_, &long_left, &bytes_left);
    }
    Qhull(const Qhull&) = delete;
    Qhull& operator=(const Qhull&) = delete;

    bool good() const { return good_; }
    bool flat() const { return flat_; }

    /// Empty if a facet is not a triangle.
    std::vector<Triangle> triangles()
    {
        std::vector<Triangle> found;
        qhT* qh = &qh_; // Qhull's macros need this name
        facetT* facet;
        FORALLfacets
        {
            if (!facet->simplicial || qh_setsize(qh, facet->vertices) != 3) return {};
            Triangle t;
            for (int k = 0; k < 3; ++k)
                t[k] = static_cast<std::uint32_t>(qh_pointid(qh, SETelemt_(facet->vertices, k, vertexT)->point));
            if (!(facet->toporient ^ qh_ORIENTclock)) std::swap(t[1], t[2]);
            found.push_back(t);
        }
        return found;
    }

private:
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> quiet_;
    qhT qh_;
    bool started_ = false, good_ = false, flat_ = false;
};

/// If points are farther outside than this share of its size, the result is no hull: the points are nearly coplanar.
constexpr double most_slack = 1e-10;

/// The points relative to their centre, divided by a power of two so that they fill about [-1, 1]^3: Qhull's tolerances
/// assume that size. Empty if all points are equal.
std::vector<double> normalised(std::span<const Eigen::Vector3d> points, const Aabb& bounds)
{
    const Eigen::Vector3d centre = 0.5 * bounds.min + 0.5 * bounds.max;
    const double half = (bounds.max - centre).maxCoeff();
    if (!(half > 0) || !std::isfinite(half)) return {};
    const int exponent = -std::ilogb(half);
    std::vector<double> coordinates;
    coordinates.reserve(3 * points.size());
    for (const Eigen::Vector3d& p : points)
        for (int axis = 0; axis < 3; ++axis) coordinates.push_back(std::ldexp(p[axis] - centre[axis], exponent));
    return coordinates;
}

std::vector<std::uint32_t> used_vertices(std::span<const Triangle> triangles)
{
    std::vector<std::uint32_t> used;
    used.reserve(3 * triangles.size());
    for (const Triangle& t : triangles) used.insert(used.end(), t.begin(), t.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    return used;
}

/// Six times the volume inside the triangles.
double signed_volume(std::span<const double> coordinates, std::span<const Triangle> triangles)
{
    const auto at = [&](std::uint32_t v) {
        return Eigen::Map<const Eigen::Vector3d>(&coordinates[3 * std::size_t(v)]);
    };
    double volume = 0;
    for (const Triangle& t : triangles) volume += at(t[0]).dot(at(t[1]).cross(at(t[2])));
    return volume;
}

/// Every point as a vertex: always valid.
Hull all_points(std::size_t count)
{
    Hull hull;
    hull.vertices.resize(count);
    std::iota(hull.vertices.begin(), hull.vertices.end(), 0u);
    return hull;
}

} // namespace

Hull convex_hull(std::span<const Eigen::Vector3d> points)
{
    constexpr std::size_t most = 700'000'000; // Qhull counts coordinates in an int
    if (points.size() < 4 || points.size() > most) return all_points(points.size());
    Aabb bounds;
    for (const Eigen::Vector3d& p : points) bounds.add(p);
    const double extent = bounds.diagonal();
    std::vector<double> coordinates = normalised(points, bounds);
    if (coordinates.empty()) return all_points(points.size());

    // Tries an exact result first, if possible (merged facets, then cut into triangles), then joggled points. Both
    // results are proved below.
    for (const char* options : {"qhull Qt Pp", "qhull QJ Pp"}) {
        Qhull qhull(coordinates, options);
        if (qhull.flat()) break;
        if (!qhull.good()) continue;
        std::vector<Triangle> triangles = qhull.triangles();
        const auto neighbours = neighbours_of(triangles);
        std::vector<std::uint32_t> vertices = used_vertices(triangles);
        // The surface is not a topological sphere.
        if (!neighbours || 2 * vertices.size() != triangles.size() + 4) continue;
        const double volume = signed_volume(coordinates, triangles);
        if (volume == 0) break;
        if (volume < 0)
            for (Triangle& t : triangles) std::swap(t[1], t[2]);
        const auto across = volume < 0 ? *neighbours_of(triangles) : *neighbours;
        const double slack = prove_slack(points, vertices, triangles, across);
        if (!(slack <= most_slack * extent)) continue;
        return {std::move(vertices), std::move(triangles), slack};
    }
    return all_points(points.size());
}

} // namespace oncollide
