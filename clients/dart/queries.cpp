// Distances and rays of the selected objects.
#include <algorithm>
#include <limits>

#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/DistanceFilter.hpp>
#include <dart/dynamics/ShapeFrame.hpp>

#include "core.hpp"

namespace dart::collision {

double OncollideCollisionDetector::Core::distance(const DistanceOption& option, DistanceResult* result)
{
    struct Candidate {
        double gap; ///< between the boxes
        const Object *a, *b;
    };
    std::vector<oncollide::Aabb> boxes;
    for (const Object* object : selected_)
        boxes.push_back(world.models().bounds(object->model->id, world.bodies().pose(object->body)));
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < selected_.size(); ++i)
        for (std::size_t j = i + 1; j < selected_.size(); ++j) {
            const Object &a = *selected_[i], &b = *selected_[j];
            if (!((a.sides & 1 && b.sides & 2) || (a.sides & 2 && b.sides & 1))) continue;
            if (option.distanceFilter && !option.distanceFilter->needDistance(&a, &b)) continue;
            const Eigen::Vector3d apart =
                (boxes[j].min - boxes[i].max).cwiseMax(boxes[i].min - boxes[j].max).cwiseMax(0.0);
            candidates.push_back({apart.norm() * (1 - 1e-15), &a, &b});
        }
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.gap < b.gap; });

    double least = std::numeric_limits<double>::infinity();
    for (const Candidate& candidate : candidates) {
        const double cutoff = std::max(least, 0.0);
        if (candidate.gap > cutoff || least <= option.distanceLowerBound) break;
        const oncollide::BodyId a = candidate.a->body, b = candidate.b->body;
        const oncollide::Distance found = world.pairs().distance(a, b, {.cutoff = cutoff});
        double value = found.upper; // rounded outward: the points have the value itself
        if (value <= cutoff) value = std::clamp((found.point_a - found.point_b).norm(), found.lower, found.upper);
        if (value == 0 && option.distanceLowerBound < 0) value = -world.pairs().penetration(a, b).depth_upper;
        if (!(value < least)) continue;
        least = value;
        if (!result) continue;
        result->shapeFrame1 = candidate.a->getShapeFrame(), result->shapeFrame2 = candidate.b->getShapeFrame();
        if (option.enableNearestPoints) result->nearestPoint1 = found.point_a, result->nearestPoint2 = found.point_b;
    }
    if (candidates.empty()) least = 0;
    const double clamped = std::max(least, option.distanceLowerBound);
    if (result) result->unclampedMinDistance = least, result->minDistance = clamped;
    return clamped;
}

bool OncollideCollisionDetector::Core::raycast(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                               const RaycastOption& option, RaycastResult* result)
{
    if (from == to) return false;
    const oncollide::Segment segment{from, to};
    constexpr oncollide::CollisionFilter selected{.layer = 3, .mask = 3};
    std::vector<oncollide::CastHit> hits;
    if (option.mEnableAllHits)
        hits = world.space().cast_all(segment, selected);
    else if (const oncollide::CastHit first = world.space().cast(segment, selected); first.body)
        hits = {first};
    if (result)
        for (const oncollide::CastHit& hit : hits) {
            RayHit& ray = result->mRayHits.emplace_back();
            ray.mCollisionObject = &object_of(hit.body);
            ray.mPoint = hit.point, ray.mNormal = hit.normal;
            ray.mFraction = (hit.fraction_lower + hit.fraction_upper) / 2;
        }
    return !hits.empty();
}

} // namespace dart::collision
