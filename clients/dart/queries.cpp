// Contacts, distances and rays of the selected objects.
#include <algorithm>
#include <limits>
#include <tuple>

#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/DistanceFilter.hpp>
#include <dart/common/Console.hpp>
#include <dart/dynamics/ShapeFrame.hpp>

#include "core.hpp"
#include "geometry_of_shape.hpp"

namespace dart::collision {

/// Pairs that meet or may meet: pairs of rigid bodies first, then by the order of their objects.
void OncollideCollisionDetector::Core::find_pairs(const CollisionFilter* filter)
{
    pairs_.clear();
    filter_ = filter;
    for (const oncollide::PairResult& pair : world.step().pairs) {
        const bool certain = pair.verdict == oncollide::Verdict::colliding;
        if (!certain && pair.verdict != oncollide::Verdict::within) continue;
        Object *a = &object_of(pair.a), *b = &object_of(pair.b);
        if (b->order < a->order) std::swap(a, b);
        pairs_.push_back({a, b, certain, a->model->soft || b->model->soft});
    }
    filter_ = nullptr;
    std::sort(pairs_.begin(), pairs_.end(), [](const Pair& p, const Pair& q) {
        return std::tuple(p.soft, p.a->order, p.b->order) < std::tuple(q.soft, q.a->order, q.b->order);
    });
}

bool OncollideCollisionDetector::Core::collide(const CollisionOption& option, CollisionResult* result)
{
    find_pairs(option.collisionFilter.get());
    if (!result && std::ranges::any_of(pairs_, &Pair::certain)) return true;
    found_.clear();
    const auto soft = std::ranges::find_if(pairs_, &Pair::soft);
    add_contacts({pairs_.begin(), soft}, options.manifold);
    oncollide::ManifoldOptions all = options.manifold; // each point mass that is inside needs a contact of its own
    all.points_per_region = 4096;
    add_contacts({soft, pairs_.end()}, all);
    keep_deepest(option.maxNumContacts);
    if (result)
        for (Found& found : found_) {
            if (!option.enableContact) found.contact.normal.setZero(), found.contact.point.setZero();
            result->addContact(found.contact);
        }
    return !found_.empty();
}

void OncollideCollisionDetector::Core::add_contacts(std::span<const Pair> pairs,
                                                    const oncollide::ManifoldOptions& manifold)
{
    bodies_.clear();
    for (const Pair& pair : pairs) bodies_.push_back({pair.a->body, pair.b->body});
    world.manifolds(bodies_, manifold, manifolds_);
    for (std::size_t i = 0; i < pairs.size(); ++i)
        add_contacts(pairs[i], std::span(manifolds_.regions)
                                   .subspan(manifolds_.offsets[i], manifolds_.offsets[i + 1] - manifolds_.offsets[i]));
}

/// The points of a pair's manifold, the deepest first.
void OncollideCollisionDetector::Core::add_contacts(const Pair& pair,
                                                    std::span<const oncollide::ManifoldRegion> regions)
{
    const auto face_of = [](const Object& object, const Eigen::Vector3d& point) {
        return object.model->soft
                   ? oncollide_client::face_near(*object.model->soft, object.getTransform().inverse() * point)
                   : 0;
    };
    Contact contact;
    contact.collisionObject1 = pair.a, contact.collisionObject2 = pair.b;
    const std::size_t before = found_.size();
    for (const oncollide::ManifoldRegion& region : regions)
        for (std::uint32_t p = region.first; p < region.first + region.count; ++p) {
            const oncollide::ManifoldPoint& point = manifolds_.points[p];
            if (point.depth < -point.depth_error) continue; // apart there
            contact.point = (point.point_a + point.point_b) / 2;
            contact.normal = -region.normal;
            contact.penetrationDepth = std::max(point.depth, 0.0);
            contact.triID1 = face_of(*pair.a, point.point_a), contact.triID2 = face_of(*pair.b, point.point_b);
            found_.push_back({0, contact});
        }
    if (found_.size() == before && pair.certain) // DART's solver skips a contact without normal
        contact.normal.setZero(), contact.penetrationDepth = 0, found_.push_back({0, contact});
    std::stable_sort(
        found_.begin() + static_cast<std::ptrdiff_t>(before), found_.end(),
        [](const Found& p, const Found& q) { return p.contact.penetrationDepth > q.contact.penetrationDepth; });
    for (std::size_t i = before; i < found_.size(); ++i) found_[i].rank = i - before;
}

/// Every pair keeps its deepest contact before any pair keeps its second, and so on.
void OncollideCollisionDetector::Core::keep_deepest(std::size_t most)
{
    if (found_.size() <= most) return;
    if (most > 1 && !std::exchange(warned_of_cut_, true)) // 1: a question of yes or no
        dtwarn << "[OncollideCollisionDetector] " << found_.size()
               << " contacts, but CollisionOption::maxNumContacts is " << most
               << ": each pair keeps its deepest ones. This is said once.\n";
    std::stable_sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
        return std::pair(a.rank, -a.contact.penetrationDepth) < std::pair(b.rank, -b.contact.penetrationDepth);
    });
    found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(most), found_.end());
}

double OncollideCollisionDetector::Core::distance(const DistanceOption& option, DistanceResult* result)
{
    struct Candidate {
        double gap; ///< between the boxes
        const Object *a, *b;
    };
    std::vector<oncollide::Aabb> boxes;
    for (const Object* object : selected_) boxes.push_back(world.bounds(object->model->id, world.pose(object->body)));
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
        const oncollide::Distance found = world.distance(a, b, 0, cutoff);
        double value = found.upper; // rounded outward: the points have the value itself
        if (value <= cutoff) value = std::clamp((found.point_a - found.point_b).norm(), found.lower, found.upper);
        if (value == 0 && option.distanceLowerBound < 0) value = -world.penetration(a, b).depth_upper;
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
    constexpr oncollide::QueryFilter selected{.layer = 3, .mask = 3};
    std::vector<oncollide::CastHit> hits;
    if (option.mEnableAllHits)
        hits = world.cast_all(segment, selected);
    else if (const auto first = world.cast(segment, selected))
        hits = {*first};
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
