#include <oncollide/scenes/model/hull_slack.hpp>

#include <algorithm>
#include <limits>
#include <tuple>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

/// The cone over one triangle from the inner point (the origin here). A point p of the cone is a combination of the
/// corners; weights (`shares`) >= 0 with a sum <= 1 prove that p is in the hull of the corners and the inner point.
struct FacetCone {
    Eigen::Matrix3d corners, planes; ///< columns: a, b, c; rows: b x c, c x a, a x b over their determinant

    explicit FacetCone(const Eigen::Matrix3d& abc) : corners(abc)
    {
        const auto a = abc.col(0), b = abc.col(1), c = abc.col(2);
        planes.row(0) = b.cross(c), planes.row(1) = c.cross(a), planes.row(2) = a.cross(b);
        planes /= std::max(a.dot(b.cross(c)), std::numeric_limits<double>::min());
    }

    /// Distance from p to a point that is certainly in the hull of the cone's corners and the inner point.
    double residual(const Eigen::Vector3d& p, Eigen::Vector3d shares) const
    {
        shares = shares.cwiseMax(0.0);
        shares /= std::max(1.0, shares.sum());
        const double distance = (p - corners * shares).norm();
        return distance >= 0 ? distance : std::numeric_limits<double>::infinity(); // a degenerate cone may give NaN
    }
};

class Prover {
public:
    Prover(std::vector<FacetCone> cones, std::span<const std::array<std::uint32_t, 3>> neighbours, double good_enough)
        : cones_(std::move(cones)), neighbours_(neighbours), good_enough_(good_enough)
    {
    }

    /// Upper bound, up to rounding, on the distance from p to the hull. Walks from the last result towards p, across
    /// the edge that p is farthest beyond; if the walk fails, tries every cone.
    double distance(const Eigen::Vector3d& p)
    {
        for (int step = 0; step < 1000; ++step) {
            const Eigen::Vector3d shares = cones_[at_].planes * p;
            int worst = 0;
            if (shares.minCoeff(&worst) < 0) {
                at_ = neighbours_[at_][worst];
                continue;
            }
            const double found = cones_[at_].residual(p, shares);
            if (found <= good_enough_) return found;
            break;
        }
        double best = std::numeric_limits<double>::infinity();
        for (const FacetCone& cone : cones_) {
            best = std::min(best, cone.residual(p, cone.planes * p));
            if (best <= good_enough_) break;
        }
        return best;
    }

private:
    std::vector<FacetCone> cones_;
    std::span<const std::array<std::uint32_t, 3>> neighbours_;
    double good_enough_;
    std::uint32_t at_ = 0;
};

} // namespace

std::optional<std::vector<std::array<std::uint32_t, 3>>> neighbours_of(std::span<const Triangle> triangles)
{
    struct Edge {
        std::uint32_t low, high;
        bool forward;
        std::uint32_t triangle, opposite;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t from = triangles[t][(corner + 1) % 3], to = triangles[t][(corner + 2) % 3];
            edges.push_back({std::min(from, to), std::max(from, to), from < to, t, corner});
        }
    const auto key = [](const Edge& e) { return std::tie(e.low, e.high, e.forward); };
    std::sort(edges.begin(), edges.end(), [&](const Edge& a, const Edge& b) { return key(a) < key(b); });

    if (edges.empty() || edges.size() % 2 != 0) return std::nullopt;
    std::vector<std::array<std::uint32_t, 3>> neighbours(triangles.size());
    for (std::size_t i = 0; i < edges.size(); i += 2) {
        const Edge &a = edges[i], &b = edges[i + 1];
        const bool pair = a.low == b.low && a.high == b.high && !a.forward && b.forward;
        const bool third = i + 2 < edges.size() && edges[i + 2].low == a.low && edges[i + 2].high == a.high;
        if (!pair || third) return std::nullopt;
        neighbours[a.triangle][a.opposite] = b.triangle;
        neighbours[b.triangle][b.opposite] = a.triangle;
    }
    return neighbours;
}

Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points, std::span<const std::uint32_t> vertices)
{
    // Extended precision: the sum of 2,000 points is still accurate to an ulp of a double.
    Eigen::Matrix<long double, 3, 1> sum = Eigen::Matrix<long double, 3, 1>::Zero();
    for (const std::uint32_t v : vertices) sum += points[v].cast<long double>();
    return (sum / static_cast<long double>(vertices.size())).cast<double>();
}

double prove_slack(std::span<const Eigen::Vector3d> points, std::span<const std::uint32_t> vertices,
                   std::span<const Triangle> triangles, std::span<const std::array<std::uint32_t, 3>> neighbours)
{
    if (points.size() == vertices.size()) return 0; // every point is a vertex
    // Coordinates are taken relative to a vertex first, so that large ones cost no accuracy, then relative to the mean.
    std::vector<Eigen::Vector3d> relative;
    relative.reserve(points.size());
    for (const Eigen::Vector3d& p : points) relative.push_back(p - points[vertices[0]]);
    const Eigen::Vector3d inner = mean_of(relative, vertices);
    double size = 0;
    for (Eigen::Vector3d& p : relative) {
        size = std::max(size, p.cwiseAbs().sum());
        p -= inner;
        size = std::max(size, p.cwiseAbs().sum());
    }
    // Both differences, the combination of corners (three products, three sums) and the length each have an error of a
    // few half ulps of `size`; the mean of half an ulp and the sum's rounding.
    const double rounding =
        24 * std::numeric_limits<double>::epsilon() * size + static_cast<double>(vertices.size()) * 0x1p-63 * size;

    std::vector<FacetCone> cones;
    cones.reserve(triangles.size());
    for (const Triangle& t : triangles) {
        Eigen::Matrix3d corners;
        for (int k = 0; k < 3; ++k) corners.col(k) = relative[t[k]];
        cones.emplace_back(corners);
    }
    Prover prover(std::move(cones), neighbours, rounding);
    double farthest = 0;
    auto vertex = vertices.begin();
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        if (vertex != vertices.end() && *vertex == i)
            ++vertex;
        else
            farthest = std::max(farthest, prover.distance(relative[i]));
    }
    return farthest + rounding;
}

} // namespace oncollide
