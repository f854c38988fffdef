// Contacts of the selected objects, from the manifolds of a frame.
#include <algorithm>
#include <span>
#include <tuple>

#include <dart/common/Console.hpp>

#include "core.hpp"
#include "geometry_of_shape.hpp"

namespace dart::collision {

/// Sets the pairs that meet or may meet: pairs of rigid bodies first, then by the objects' order.
void OncollideCollisionDetector::Core::find_pairs(std::span<const oncollide::PairResult> results)
{
    const oncollide::FrameManifolds& found = world.manifolds(options.manifold); // in the order of the results
    pairs_.clear(), soft_pairs_.clear();
    std::size_t next = 0;
    for (const oncollide::PairResult& result : results) {
        const bool has_manifold =
            next < found.pairs.size() && found.pairs[next].a == result.a && found.pairs[next].b == result.b;
        const std::size_t place = has_manifold ? next++ : none;
        const bool certain = result.verdict == oncollide::Verdict::colliding;
        if (!certain && result.verdict != oncollide::Verdict::within) continue;
        Object &a = object_of(result.a), &b = object_of(result.b);
        pairs_.push_back({&a, &b, certain, a.model->soft || b.model->soft, &found, place});
    }
    std::sort(pairs_.begin(), pairs_.end(), [](const Pair& p, const Pair& q) {
        return std::tuple(p.soft, p.a->order, p.b->order) < std::tuple(q.soft, q.a->order, q.b->order);
    });
    for (Pair& pair : pairs_) {
        if (!pair.soft) continue;
        pair.lists = &soft_manifolds_, pair.place = soft_pairs_.size();
        soft_pairs_.push_back({pair.a->body, pair.b->body});
    }
    oncollide::ManifoldOptions all = options.manifold; // each point mass that is inside needs a contact of its own
    all.points_per_region = 4096;
    if (!soft_pairs_.empty()) world.pairs().manifold(soft_pairs_, all, soft_manifolds_);
}

bool OncollideCollisionDetector::Core::collide(const CollisionOption& option, CollisionResult* result)
{
    filter_ = option.collisionFilter.get();
    const std::span<const oncollide::PairResult> results = world.step().pairs;
    filter_ = nullptr;
    const auto certain = [](const oncollide::PairResult& r) { return r.verdict == oncollide::Verdict::colliding; };
    if (!result && std::ranges::any_of(results, certain)) return true;
    find_pairs(results);
    found_.clear();
    for (const Pair& pair : pairs_) add_contacts(pair);
    keep_deepest(option.maxNumContacts);
    if (result)
        for (Found& found : found_) {
            if (!option.enableContact) found.contact.normal.setZero(), found.contact.point.setZero();
            result->addContact(found.contact);
        }
    return !found_.empty();
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
void OncollideCollisionDetector::Core::add_contacts(const Pair& pair)
{
    const std::size_t before = found_.size();
    const std::size_t end = pair.place == none ? 0 : pair.lists->offsets[pair.place + 1];
    for (std::size_t r = pair.place == none ? 0 : pair.lists->offsets[pair.place]; r < end; ++r) {
        const oncollide::ManifoldRegion& region = pair.lists->regions[r];
        for (std::uint32_t p = region.first; p < region.first + region.count; ++p)
            if (const oncollide::ManifoldPoint& point = pair.lists->points[p]; point.depth >= -point.depth_error)
                add_contact(pair, point);
    }
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    if (found_.size() == before && pair.certain) // DART's solver skips a contact without normal
        add_contact(pair, {zero, zero, 0, 0, 0, 0, zero});
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
