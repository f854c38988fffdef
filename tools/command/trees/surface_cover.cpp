#include "trees/surface_cover.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr int most_halvings = 100; // two halvings halve all lengths, so pieces end at 2^-50 of a fine one

double area(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    return 0.5 * (b - a).cross(c - a).norm();
}

} // namespace

SurfaceCover::SurfaceCover(const Mesh& mesh, const SurfaceIndex& index, std::span<const CoveringVolume> volumes)
    : mesh_(mesh), volumes_(volumes),
      slack_(1e-12 * std::max({mesh.bounds.diagonal(), mesh.bounds.min.norm(), mesh.bounds.max.norm()})),
      fine_(std::numeric_limits<double>::infinity()), near_end_(mesh.triangles.size())
{
    for (const CoveringVolume& v : volumes) fine_ = std::min(fine_, v.radius() / 16);
    fine_ = std::max(fine_, slack_);
    // The first pass counts, the second fills.
    const auto for_each_near = [&](auto&& visit) {
        for (std::uint32_t i = 0; i < volumes.size(); ++i)
            index.near(volumes[i].centre, volumes[i].radius() + slack_, [&](std::uint32_t t) { visit(t, i); });
    };
    for_each_near([&](std::uint32_t t, std::uint32_t) { ++near_end_[t]; });
    std::size_t sum = 0;
    for (std::size_t& end : near_end_) sum += std::exchange(end, sum);
    near_.resize(sum);
    for_each_near([&](std::uint32_t t, std::uint32_t volume) { near_[near_end_[t]++] = volume; });
}

std::span<const std::uint32_t> SurfaceCover::volumes_at(std::size_t triangle) const
{
    const std::size_t begin = triangle ? near_end_[triangle - 1] : 0;
    return std::span(near_).subspan(begin, near_end_[triangle] - begin);
}

SurfaceCover::Piece SurfaceCover::piece(std::size_t triangle) const
{
    const Triangle& t = mesh_.triangles[triangle];
    return {{mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]}};
}

/// True if the whole piece is in one of the volumes. Otherwise `reached` receives the volumes near it.
bool SurfaceCover::in_one(const Piece& p, std::span<const std::uint32_t> candidates,
                          std::vector<std::uint32_t>& reached) const
{
    const auto& [a, b, c] = p.corner;
    const Vector3d middle = (a + b + c) / 3;
    const double size = std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()});
    for (const std::uint32_t i : candidates) {
        const CoveringVolume& v = volumes_[i];
        if (v.holds(a, slack_) && v.holds(b, slack_) && v.holds(c, slack_)) return true;
        if (v.holds(middle, slack_ + size)) reached.push_back(i);
    }
    return false;
}

/// Halves the piece across its longest edge.
std::array<SurfaceCover::Piece, 2> SurfaceCover::halves(const Piece& p)
{
    int longest = 0;
    for (int k = 1; k < 3; ++k)
        if ((p.corner[(k + 1) % 3] - p.corner[k]).squaredNorm() >
            (p.corner[(longest + 1) % 3] - p.corner[longest]).squaredNorm())
            longest = k;
    Piece first = p, second = p;
    const Vector3d middle = 0.5 * (p.corner[longest] + p.corner[(longest + 1) % 3]);
    first.corner[(longest + 1) % 3] = second.corner[longest] = middle;
    return {first, second};
}

bool SurfaceCover::covered(const Piece& p, std::span<const std::uint32_t> candidates, int left) const
{
    std::vector<std::uint32_t> reached;
    if (in_one(p, candidates, reached)) return true;
    if (left == 0 || reached.empty()) return false;
    const auto [first, second] = halves(p);
    return covered(first, reached, left - 1) && covered(second, reached, left - 1);
}

double SurfaceCover::uncovered(const Piece& p, std::span<const std::uint32_t> candidates, bool& open) const
{
    const auto& [a, b, c] = p.corner;
    std::vector<std::uint32_t> reached;
    if (in_one(p, candidates, reached)) return 0;
    const bool fine = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}) < fine_;
    if (fine && covered(p, reached, most_halvings)) return 0;
    if (fine || reached.empty()) {
        open = true;
        return area(a, b, c);
    }
    const auto [first, second] = halves(p);
    return uncovered(first, reached, open) + uncovered(second, reached, open);
}

double SurfaceCover::uncovered_area(std::size_t& open_triangles) const
{
    double sum = 0;
    open_triangles = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        bool open = false;
        sum += uncovered(piece(t), volumes_at(t), open);
        open_triangles += open;
    }
    return sum;
}

std::size_t SurfaceCover::points_outside(std::size_t count, std::size_t& looked) const
{
    double total = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        const auto& [a, b, c] = piece(t).corner;
        total += area(a, b, c);
    }
    std::size_t outside = 0;
    looked = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        const auto& [a, b, c] = piece(t).corner;
        const auto look = [&](const Vector3d& point) {
            const auto near = volumes_at(t);
            ++looked;
            outside += std::none_of(near.begin(), near.end(),
                                    [&](std::uint32_t i) { return volumes_[i].holds(point, slack_); });
        };
        for (const Vector3d& corner : {a, b, c, Vector3d((a + b + c) / 3)}) look(corner);
        const double share = total > 0 ? area(a, b, c) / total : 0;
        for (std::uint64_t k = 0; k < std::uint64_t(share * double(count)); ++k) {
            double u = u01(t, k, 0), v = u01(t, k, 1);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            look((1 - u - v) * a + u * b + v * c);
        }
    }
    return outside;
}

} // namespace oncollide::tools
