#include <oncollide/robots/spheres/sphere_judge.hpp>

#include <algorithm>
#include <cmath>
#include <queue>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

namespace oncollide {

namespace {

using Corners = LinkSurface::Corners;
using Eigen::Vector3d;

/// How far a point is from a sphere; negative: inside.
double beyond(const CoverSphere& sphere, const Vector3d& point)
{
    return (point - sphere.centre).norm() - sphere.radius;
}

/// A sphere is convex: a triangle lies in it if its corners do. Rounding may only make it return false.
bool contains(const CoverSphere& sphere, const Corners& triangle)
{
    const double radius = sphere.radius * (1 - 1e-14) - 1e-15 * sphere.centre.cwiseAbs().maxCoeff();
    return radius > 0 && std::ranges::all_of(triangle, [&](const Vector3d& corner) {
               return (corner - sphere.centre).squaredNorm() <= radius * radius;
           });
}

bool meets(const CoverSphere& sphere, const Corners& triangle)
{
    return (nearest_on(triangle, sphere.centre).at - sphere.centre).norm() <= sphere.radius * (1 + 1e-12) + 1e-15;
}

class CoverJudge {
public:
    CoverJudge(std::span<const CoverSphere> spheres, const JudgeOptions& options) : spheres_(spheres), options_(options)
    {
    }

    /// Adds a triangle's areas to `result`. `near` holds the spheres that may meet the triangle.
    void area(const Corners& triangle, const std::vector<std::uint32_t>& near, CoverJudgement& result)
    {
        std::vector<std::uint32_t> mine;
        for (const std::uint32_t i : near) {
            if (contains(spheres_[i], triangle)) return;
            if (meets(spheres_[i], triangle)) mine.push_back(i);
        }
        const double size = area_of(triangle);
        if (mine.empty()) {
            result.uncovered += size, result.uncovered_most += size;
        } else if (longest_edge(triangle) < options_.edge) {
            result.uncovered_most += size;
        } else {
            for (const Corners& half : halves_of(triangle)) area(half, mine, result);
            return;
        }
        result.complete = false;
    }

    /// The largest gap, by branch and bound: a distance from a sphere is convex, so a triangle's points are no farther
    /// from the best sphere than its corners are.
    void gap(std::span<const Corners> triangles, CoverJudgement& result)
    {
        struct Entry {
            double most;
            Corners triangle;
            bool operator<(const Entry& other) const { return most < other.most; }
        };
        std::priority_queue<Entry> open;
        const auto add = [&](const Corners& triangle) {
            double most = infinity;
            for (const CoverSphere& sphere : spheres_) {
                double farthest = -infinity;
                for (const Vector3d& corner : triangle) farthest = std::max(farthest, beyond(sphere, corner));
                most = std::min(most, farthest);
            }
            for (const Vector3d& corner : triangle) {
                double least = infinity;
                for (const CoverSphere& sphere : spheres_) least = std::min(least, beyond(sphere, corner));
                if (least > result.gap) result.gap = least, result.worst = corner;
            }
            if (most > result.gap + options_.gap) open.push({most, triangle});
        };
        for (const Corners& triangle : triangles) add(triangle);
        while (!open.empty() && open.top().most > result.gap + options_.gap) {
            const Corners triangle = open.top().triangle;
            open.pop();
            for (const Corners& half : halves_of(triangle)) add(half);
        }
        result.gap_most = result.complete ? 0
                                          : (open.empty() ? result.gap + options_.gap
                                                          : std::max(open.top().most, result.gap + options_.gap));
        if (result.complete) result.gap = 0;
    }

private:
    std::span<const CoverSphere> spheres_;
    const JudgeOptions& options_;
};

} // namespace

CoverJudgement judge_cover(const LinkSurface& surface, std::span<const CoverSphere> spheres,
                           const JudgeOptions& options)
{
    CoverJudgement result;
    result.area = surface.area(), result.complete = true;
    if (spheres.empty()) {
        result.complete = surface.triangles().empty();
        result.uncovered = result.uncovered_most = result.area;
        result.gap = result.gap_most = infinity;
        return result;
    }
    std::vector<std::uint32_t> all(spheres.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    CoverJudge judge(spheres, options);
    for (const Corners& triangle : surface.triangles()) judge.area(triangle, all, result);
    judge.gap(surface.triangles(), result);
    for (const CoverSphere& sphere : spheres)
        result.over_reach = std::max(result.over_reach, sphere.radius + surface.signed_distance(sphere.centre));
    return result;
}

} // namespace oncollide
