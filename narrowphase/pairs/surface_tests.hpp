// Tests of two bodies with triangles: meshes, terrains, boxes and hulls. Included by the table alone.
#pragma once
#include <concepts>
#include <optional>
#include <variant>
#include <vector>

#include <oncollide/narrowphase/pairs/depth_bounds.hpp>
#include <oncollide/narrowphase/pairs/direct_tests.hpp>
#include <oncollide/narrowphase/pairs/triangle_pairs.hpp>
#include <oncollide/narrowphase/pairs/walk_tests.hpp>

namespace oncollide::surface_tests {

using operand::Polytope;

inline std::optional<TrianglePair> hint_of(const PairMemory* memory)
{
    return memory && memory->met ? std::optional(memory->triangles) : std::nullopt;
}

inline void remember(PairMemory* memory, const std::optional<TrianglePair>& meeting)
{
    if (!memory) return;
    memory->met = meeting.has_value();
    if (meeting) memory->triangles = *meeting;
}

/// The position in the trees where a pair met last; a traversal starts there and updates it.
template <class A, class B>
class RememberedHint {
public:
    explicit RememberedHint(PairMemory* memory) : memory_(memory)
    {
        const auto* place = memory ? std::get_if<MeetingHint<A, B>>(&memory->place) : nullptr;
        if (place) place_ = *place;
    }
    ~RememberedHint()
    {
        if (memory_ && place_) memory_->place = *place_;
    }
    RememberedHint(const RememberedHint&) = delete;
    RememberedHint& operator=(const RememberedHint&) = delete;
    std::optional<MeetingHint<A, B>>* get() { return memory_ ? &place_ : nullptr; }

private:
    PairMemory* memory_;
    std::optional<MeetingHint<A, B>> place_;
};
template <>
class RememberedHint<TerrainTree, TerrainTree> { // such pairs are few and large, so no place is kept
public:
    explicit RememberedHint(PairMemory*) {}
    std::optional<MeetingHint<TerrainTree, TerrainTree>>* get() { return nullptr; }
};

template <class A, class B>
bool inexact(const PairTask& task)
{
    return A::error(*task.a) + B::error(*task.b) > 0;
}

template <class A, class B>
Finding decide(PairWorker& worker, const PairTask& task, const PairOptions& options, PairMemory* memory)
{
    if (inexact<A, B>(task))
        return walk_tests::decide_off(walk_tests::walk_pair<A, B>(worker, task, false), options.clearance);
    auto& a = A::tree(*task.a);
    auto& b = B::tree(*task.b);
    auto& walk = worker.traversal(a, b);
    const RelativePose b_to_a(*task.pose_a, *task.pose_b);
    RememberedHint<std::remove_reference_t<decltype(a)>, std::remove_reference_t<decltype(b)>> place(memory);
    double bound = 0;
    if (!options.kinds) {
        const auto [meeting, gap] = walk.first_meeting(a, b, b_to_a, hint_of(memory), place.get());
        remember(memory, meeting);
        if (meeting) return {Verdict::colliding, ContactKind::unknown, 0};
        bound = gap;
    } else {
        // Closed meshes that only touch in all pairs of triangles may still share an interior point. For a mesh and its
        // copy, a point beside the first contact is such a point.
        constexpr bool meshes = std::same_as<decltype(walk), Traversal&>;
        const auto have_insides = [&] { return task.a->has_inside() && task.b->has_inside(); };
        const auto overlap = [&](TrianglePair pair) {
            if constexpr (meshes) return have_insides() && worker.inside.is_beside(a, b, b_to_a, pair);
            return false;
        };
        auto [meeting, gap, contact, parted] = walk.contact(a, b, b_to_a, hint_of(memory), place.get(), overlap);
        remember(memory, meeting);
        if constexpr (meshes)
            if (contact == TriangleContact::touching && !parted && have_insides() &&
                worker.inside.find(a, b, b_to_a, true))
                contact = TriangleContact::crossing;
        const bool touching = contact == TriangleContact::touching;
        if (meeting)
            return {touching && options.ignore_touching ? Verdict::separate : Verdict::colliding,
                    touching ? ContactKind::touching : ContactKind::crossing, 0};
        bound = gap;
    }
    constexpr bool solid_a = std::same_as<A, Polytope>, solid_b = std::same_as<B, Polytope>;
    if constexpr (solid_a || solid_b)
        if (polytope_holds(worker, task)) return {Verdict::colliding, ContactKind::enclosed, 0};
    if (options.clearance == 0) return {Verdict::separate, ContactKind::unknown, bound};
    if constexpr (solid_a && solid_b)
        return direct_tests::by_distance(direct_tests::TwoShapes(task, false), options.clearance);
    else
        return walk_tests::by_distance(walk_tests::walk_pair<A, B>(worker, task, false), options.clearance);
}

template <class A, class B>
Finding near(PairWorker& worker, const PairTask& task, double clearance, double tolerance, PairMemory* memory)
{
    if (std::same_as<A, Polytope> || std::same_as<B, Polytope> || inexact<A, B>(task))
        return walk_tests::near(walk_tests::walk_pair<A, B>(worker, task, false), clearance, tolerance, memory);
    auto& a = A::tree(*task.a);
    auto& b = B::tree(*task.b);
    RememberedHint<std::remove_reference_t<decltype(a)>, std::remove_reference_t<decltype(b)>> place(memory);
    const auto found = worker.traversal(a, b).near(a, b, RelativePose(*task.pose_a, *task.pose_b), clearance, tolerance,
                                                   hint_of(memory), place.get());
    remember(memory, found.witness);
    return {found.near ? Verdict::within : Verdict::separate, ContactKind::unknown, found.bound};
}

/// The distance of two meshes or terrains.
template <class A, class B>
Distance distance(PairWorker& worker, const PairTask& task, const DistanceOptions& options)
{
    if (inexact<A, B>(task)) return walk_tests::distance(walk_tests::walk_pair<A, B>(worker, task, false), options);
    auto& a = A::tree(*task.a);
    auto& b = B::tree(*task.b);
    return triangle_distance(worker.traversal(a, b), a, *task.pose_a, b, *task.pose_b, options);
}

template <class A, class B>
void contacts(PairWorker& worker, const PairTask& task, std::vector<Contact>& found)
{
    auto& a = A::tree(*task.a);
    auto& b = B::tree(*task.b);
    triangle_contacts(worker.traversal(a, b), a, *task.pose_a, b, *task.pose_b, worker.pairs, found);
}

inline Penetration penetration(PairWorker& worker, const PairTask& task)
{
    worker.meetings.clear();
    contacts<operand::Triangles, operand::Triangles>(worker, task, worker.meetings);
    Penetration found = worker.penetration.measure(task, worker.meetings, worker.locator,
                                                   worker.traversal(*task.a->obb_tree(), *task.b->obb_tree()));
    if (task.a->kind() == Kind::polytope && task.b->kind() == Kind::polytope) set_parting(task, found);
    return found;
}

} // namespace oncollide::surface_tests
