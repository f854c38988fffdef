// Contacts of the selected objects, from manifolds.
#include <algorithm>
#include <span>
#include <tuple>

#include <dart/common/Console.hpp>

#include "core.hpp"
#include "geometry_of_shape.hpp"

namespace dart::collision {

/// Sets the pairs that meet or may meet: pairs of rigid bodies first, then by the objects' order.
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
    world.pairs().manifold(bodies_, manifold, manifolds_);
    for (std::size_t i = 0; i < pairs.size(); ++i)
        add_contacts(pairs[i], std::span(manifolds_.regions)
                                   .subspan(manifolds_.offsets[i], manifolds_.offsets[i + 1] - manifolds_.offsets[i]));
}

void OncollideCollisionDetector::Core::add_contact(const Pair& pair, const oncollide::ManifoldPoint& point)
{
    const Eigen::Vector3d at = (point.point_a + point.point_b) / 2;
    const auto face = [&](const Object& object) {
        const dynamics::SoftMeshShape* soft = object.model->soft;
        return soft ? oncollide_client::face_near(*soft, object.getTransform().inverse() * at) : 0;
    };
    Contact contact;
    contact.collisionObject1 = pair.a, contact.collisionObject2 = pair.b;
    contact.point = at, contact.normal = -point.normal, contact.penetrationDepth = std::max(point.depth, 0.0);
    contact.triID1 = face(*pair.a), contact.triID2 = face(*pair.b);
    found_.push_back({0, {point.feature_a, point.feature_b}, contact});
}

/// The points of a pair's manifold, in the order of their features.
void OncollideCollisionDetector::Core::add_contacts(const Pair& pair,
                                                    std::span<const oncollide::ManifoldRegion> regions)
{
    const std::size_t before = found_.size();
    for (const oncollide::ManifoldRegion& region : regions)
        for (std::uint32_t p = region.first; p < region.first + region.count; ++p)
            if (const oncollide::ManifoldPoint& point = manifolds_.points[p]; point.depth >= -point.depth_error)
                add_contact(pair, point);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    if (found_.size() == before && pair.certain) // DART's solver skips a contact without normal
        add_contact(pair, {none, none, 0, 0, 0, 0, none});
    const auto first = found_.begin() + static_cast<std::ptrdiff_t>(before);
    std::stable_sort(first, found_.end(), [](const Found& p, const Found& q) {
        return p.contact.penetrationDepth > q.contact.penetrationDepth;
    });
    for (std::size_t i = before; i < found_.size(); ++i) found_[i].rank = i - before;
    // The impulses of DART's solver depend on the order. In this one a stack rests; by depths it creeps (docs/dart.md).
    std::stable_sort(first, found_.end(), [](const Found& p, const Found& q) { return p.features < q.features; });
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

} // namespace dart::collision
