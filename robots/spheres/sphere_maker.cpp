#include <oncollide/robots/spheres/sphere_maker.hpp>

#include <algorithm>
#include <cmath>
#include <queue>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

namespace {

using Corners = LinkSurface::Corners;
using Eigen::Vector3d;

constexpr std::size_t sampled_points = 250, most_patches = 16'000;

void divide(const Corners& triangle, double edge, std::vector<Corners>& patches)
{
    if (longest_edge(triangle) <= edge) return patches.push_back(triangle);
    for (const Corners& half : halves_of(triangle)) divide(half, edge, patches);
}

bool contains(const Vector3d& centre, double radius, const Corners& triangle)
{
    const double square = radius * radius;
    return (triangle[0] - centre).squaredNorm() <= square && (triangle[1] - centre).squaredNorm() <= square &&
           (triangle[2] - centre).squaredNorm() <= square;
}

double farthest_corner(const Vector3d& centre, const Corners& triangle)
{
    double square = 0;
    for (const Vector3d& corner : triangle) square = std::max(square, (corner - centre).squaredNorm());
    return std::sqrt(square);
}

/// Room for programs that round to float, within a metre of the link's origin.
double outward(double radius)
{
    return radius * (1 + 2e-7) + 2e-7;
}

/// The choice among candidates, for one error.
class Choice {
public:
    Choice(std::span<const Corners> patches) : patches_(patches), left_(patches.size(), 1), count_(patches.size()) {}

    void offer(const Vector3d& centre, double radius)
    {
        std::vector<std::uint32_t> covers;
        for (std::uint32_t i = 0; i < patches_.size(); ++i)
            if (contains(centre, radius, patches_[i])) covers.push_back(i);
        if (covers.empty()) return;
        gains_.push({covers.size(), spheres_.size()});
        spheres_.push_back({centre, radius}), covers_.push_back(std::move(covers));
    }

    /// Chvatal's greedy set cover; gains only fall, so an old gain is an upper bound.
    void choose()
    {
        while (count_ > 0 && !gains_.empty()) {
            const auto [old, i] = gains_.top();
            gains_.pop();
            const auto gain = static_cast<std::size_t>(
                std::ranges::count_if(covers_[i], [&](std::uint32_t patch) { return left_[patch] != 0; }));
            if (gain == 0) continue;
            if (!gains_.empty() && gain < gains_.top().first) {
                gains_.push({gain, i});
                continue;
            }
            for (const std::uint32_t patch : covers_[i]) count_ -= left_[patch], left_[patch] = 0;
            chosen_.push_back(i);
        }
    }

    void take(std::vector<CoverSphere>& chosen) const
    {
        for (const std::size_t i : chosen_) chosen.push_back(spheres_[i]);
    }

    /// Patches in no candidate.
    std::vector<Corners> left() const
    {
        std::vector<Corners> patches;
        for (std::size_t i = 0; i < patches_.size(); ++i)
            if (left_[i]) patches.push_back(patches_[i]);
        return patches;
    }

    /// The chosen spheres without superfluous ones. Each is reduced to the patches that no other sphere covers.
    std::vector<CoverSphere> shrunk() const
    {
        std::vector<std::uint32_t> times(patches_.size());
        for (const std::size_t i : chosen_)
            for (const std::uint32_t patch : covers_[i]) ++times[patch];
        std::vector<CoverSphere> spheres;
        for (auto at = chosen_.rbegin(); at != chosen_.rend(); ++at) { // the last spheres add least
            double radius = 0;
            for (const std::uint32_t patch : covers_[*at])
                if (times[patch] == 1)
                    radius = std::max(radius, farthest_corner(spheres_[*at].centre, patches_[patch]));
            for (const std::uint32_t patch : covers_[*at])
                times[patch] -= farthest_corner(spheres_[*at].centre, patches_[patch]) > radius;
            if (radius > 0) spheres.push_back({spheres_[*at].centre, outward(radius)});
        }
        return spheres;
    }

private:
    std::span<const Corners> patches_;
    std::vector<std::uint8_t> left_;
    std::size_t count_;
    std::vector<CoverSphere> spheres_;
    std::vector<std::vector<std::uint32_t>> covers_;
    std::priority_queue<std::pair<std::size_t, std::size_t>> gains_;
    std::vector<std::size_t> chosen_;
};

} // namespace

SphereMaker::SphereMaker(const LinkSurface& surface) : surface_(surface)
{
    const double spacing = std::sqrt(surface.area() / double(sampled_points));
    std::vector<Corners> patches;
    for (const Corners& triangle : surface.triangles()) divide(triangle, 1.5 * spacing, patches);
    const std::size_t step = std::max<std::size_t>(1, patches.size() / (2 * sampled_points));
    for (std::size_t i = 0; i < patches.size(); i += step) add_candidates(patches[i], candidates_);
}

void SphereMaker::add_candidates(const Corners& patch, std::vector<Candidate>& candidates) const
{
    const Vector3d normal = (patch[1] - patch[0]).cross(patch[2] - patch[0]);
    if (!(normal.norm() > 0)) return;
    const Vector3d point = (patch[0] + patch[1] + patch[2]) / 3;
    const auto add = [&](const Vector3d& centre) {
        candidates.push_back({centre, -surface_.signed_distance(centre)});
        return candidates.back().depth;
    };
    Vector3d inward = -normal.normalized();
    if (add(point + 1e-3 * surface_.size() * inward) <= 0) inward = -inward; // the mesh is inside out
    const double thickness = surface_.thickness(point, inward);
    for (const double part : {0.5, 0.35, 0.2, 0.1, 0.05, 0.0}) add(point + part * thickness * inward);
    // The centre moves away from the nearest point of the surface.
    Vector3d centre = point + 0.5 * thickness * inward;
    for (int k = 0; k < 3; ++k) {
        const Vector3d away = centre - surface_.nearest(centre);
        if (!(away.norm() > 0)) break;
        const double room = surface_.thickness(centre - away, away.normalized()) / 2 - away.norm();
        if (!(room > 1e-3 * surface_.size())) break;
        add(centre += room * away.normalized());
    }
}

CoverSphere SphereMaker::single() const
{
    std::vector<Vector3d> corners;
    for (const Corners& triangle : surface_.triangles())
        corners.insert(corners.end(), triangle.begin(), triangle.end());
    CoverSphere sphere = enclosing_sphere(corners);
    sphere.radius = outward(sphere.radius);
    return sphere;
}

std::vector<CoverSphere> SphereMaker::within(double max_error) const
{
    if (surface_.triangles().empty()) return {};
    if (const CoverSphere one = single(); one.radius + surface_.signed_distance(one.centre) <= max_error) return {one};
    // Patches are a fraction of the error wide, but no more of them than memory has room for.
    const double edge = std::max(0.7 * max_error, std::sqrt(3 * surface_.area() / double(most_patches)));
    std::vector<Corners> patches;
    for (const Corners& triangle : surface_.triangles()) divide(triangle, edge, patches);
    const double error = max_error * (1 - 1e-6) - 4e-7; // room for rounding outward
    // Each round adds candidates near the patches that are left.
    std::vector<CoverSphere> chosen;
    std::vector<Corners> left = patches;
    std::vector<Candidate> candidates = candidates_;
    for (int round = 0; round < 20 && !left.empty(); ++round) {
        Choice choice(left);
        for (const Candidate& candidate : candidates)
            if (candidate.depth + error > 0) choice.offer(candidate.centre, candidate.depth + error);
        choice.choose();
        const std::size_t before = left.size();
        choice.take(chosen);
        left = choice.left();
        if (left.size() == before) break;
        candidates.clear();
        const std::size_t step = std::max<std::size_t>(1, left.size() / sampled_points);
        for (std::size_t i = 0; i < left.size(); i += step) add_candidates(left[i], candidates);
    }
    Choice all(patches);
    for (const CoverSphere& sphere : chosen) all.offer(sphere.centre, sphere.radius);
    all.choose();
    std::vector<CoverSphere> spheres = all.shrunk();
    // Patches without a candidate are halved until small spheres around them fit.
    while (!left.empty()) {
        const Corners patch = left.back();
        left.pop_back();
        CoverSphere small = enclosing_sphere(patch);
        small.radius = outward(small.radius);
        if (small.radius + surface_.signed_distance(small.centre) <= max_error)
            spheres.push_back(small);
        else
            for (const Corners& half : halves_of(patch)) left.push_back(half);
    }
    return spheres;
}

} // namespace oncollide
