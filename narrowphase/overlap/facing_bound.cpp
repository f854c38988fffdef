#include <oncollide/narrowphase/overlap/facing_bound.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {
namespace {

using Eigen::Vector3d;

/// The share in [0, 1] of `end` at which slope * share + reach * |from + share * (end - from)| is least.
double best_share(const Vector3d& from, const Vector3d& end, double slope, double reach)
{
    const Vector3d step = end - from;
    const double length = step.norm();
    if (!(length > 0)) return slope < 0 ? 1 : 0;
    const double nearest = -from.dot(step) / (length * length); // to the origin
    const double pull = -slope / (reach * length);              // cosine of the angle at the least
    if (pull >= 1) return 1;
    if (pull <= -1) return 0;
    const double aside = (from + nearest * step).norm() / length;
    return std::clamp(nearest + aside * pull / std::sqrt(1 - pull * pull), 0.0, 1.0);
}

} // namespace

void FacingBound::add(const PlacedFaces::Face& face, const Vector3d& way)
{
    const double distance = way.norm();
    faces_.push_back({&face, distance, distance > 0 ? Vector3d(-way / distance) : Vector3d(Vector3d::Zero()), 0});
}

/// Sets weights for which the mean's first-order bound is low, by the method of Frank and Wolfe. False if it stays
/// above `enough`, and then the mean is no better.
bool FacingBound::balance(double reach, double enough)
{
    constexpr int most_steps = 16;
    Near& first = *std::ranges::min_element(faces_, {}, [](const Near& near) { return near.distance; });
    first.weight = 1;
    double mean = first.distance;
    Vector3d pull = first.away;
    for (int step = 0; step < most_steps; ++step) {
        const double length = pull.norm();
        if (mean + reach * length <= 0.98 * enough) return true;
        const Vector3d direction = length > 0 ? Vector3d(reach / length * pull) : Vector3d(Vector3d::Zero());
        Near* best = nullptr;
        double least = mean + reach * length;
        for (Near& near : faces_)
            if (const double value = near.distance + direction.dot(near.away); value < least)
                least = value, best = &near;
        if (!best) break;
        const double share = best_share(pull, best->away, best->distance - mean, reach);
        if (!(share > 0)) break;
        for (Near& near : faces_) near.weight *= 1 - share;
        best->weight += share;
        mean += share * (best->distance - mean), pull += share * (best->away - pull);
    }
    return mean <= enough;
}

double FacingBound::find(const Aabb& box, double reach, double enough)
{
    if (faces_.empty() || !balance(reach, enough)) return std::numeric_limits<double>::infinity();
    std::array<double, 8> sums{};
    double weights = 0;
    for (const Near& near : faces_) {
        if (near.weight < 1e-6) continue;
        weights += near.weight;
        for (unsigned k = 0; k < 8; ++k) {
            const Vector3d corner((k & 1 ? box.max : box.min).x(), (k & 2 ? box.max : box.min).y(),
                                  (k & 4 ? box.max : box.min).z());
            sums[k] += near.weight * distance_of(corner, near.face->corners);
        }
    }
    return *std::ranges::max_element(sums) / weights;
}

} // namespace oncollide
