#include <oncollide/narrowphase/walks/traversal.hpp>

#include <algorithm>

#include <oncollide/narrowphase/exact/common_corner.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/walks/box_walk_all.hpp>
#include <oncollide/narrowphase/walks/box_walk_distance.hpp>
#include <oncollide/narrowphase/walks/box_walk_entry.hpp>

namespace oncollide {

static_assert(BoxHierarchy<ObbTree> && LeafTests<TriangleTests, ObbTree, ObbTree>);
static_assert(BoxHierarchy<TerrainTree> && LeafTests<TriangleTestsOf<TerrainTree, ObbTree>, TerrainTree, ObbTree>);
template class BoxWalk<ObbTree, ObbTree, TriangleTests>;
template class BoxWalk<TerrainTree, ObbTree, TriangleTestsOf<TerrainTree, ObbTree>>;
template class BoxWalk<ObbTree, TerrainTree, TriangleTestsOf<ObbTree, TerrainTree>>;
template class BoxWalk<TerrainTree, TerrainTree, TriangleTestsOf<TerrainTree, TerrainTree>>;

namespace {

constexpr auto leave_none = [](TrianglePair) { return false; };

void sort_pairs(std::vector<TrianglePair>& pairs)
{
    std::ranges::sort(pairs, {}, [](const TrianglePair& pair) { return std::uint64_t{pair.a} << 32 | pair.b; });
}

} // namespace

template <class A, class B>
typename TraversalOf<A, B>::Meeting TraversalOf<A, B>::first_meeting(A& a, B& b, const RelativePose& b_to_a,
                                                                     std::optional<TrianglePair> hint,
                                                                     std::optional<Place>* place)
{
    Meeting meeting;
    const auto found = [&](TrianglePair pair) {
        meeting.pair = pair;
        return false;
    };
    meeting.bound = walk_.meetings(a, b, b_to_a, hint, found, leave_none, place);
    return meeting;
}

template <class A, class B>
typename TraversalOf<A, B>::Contact
TraversalOf<A, B>::contact(A& a, B& b, const RelativePose& b_to_a, std::optional<TrianglePair> hint,
                           std::optional<Place>* place, FunctionRef<bool(TrianglePair)> overlap)
{
    const Tests& triangles = walk_.leaves();
    Contact contact;
    const auto take = [&](TrianglePair pair) {
        const TriangleContact how = triangle_contact(triangles.points_a(pair.a), triangles.points_b(pair.b));
        if (how > contact.kind) contact.pair = pair, contact.kind = how;
        return how;
    };
    const auto corners_touch_at_most = [&](TrianglePair pair) {
        if (contact.kind != TriangleContact::touching) return false;
        const TrianglePoints of_a = triangles.points_a(pair.a), of_b = triangles.points_b(pair.b);
        return have_common_edge(of_a, of_b) || only_common_corner(of_a, of_b);
    };
    if constexpr (!two_meshes<A, B>) { // few triangles of a terrain meet in a point, and a terrain has no inside
        contact.bound = walk_.meetings(
            a, b, b_to_a, hint, [&](TrianglePair pair) { return take(pair) != TriangleContact::crossing; },
            corners_touch_at_most, place);
        return contact;
    } else {
        // Two fans of n triangles that touch in one plane or in a point give n^2 pairs: one plane decides all of them.
        planes_.start(a.mesh(), b.mesh(), b_to_a);
        int tried = 0;
        constexpr int most_tried = 4;
        const auto found = [&](TrianglePair pair) {
            if (take(pair) == TriangleContact::touching && !planes_.part(pair.a, pair.b)) {
                planes_.add(pair.a, pair.b);
                if (!planes_.part_all() && tried++ < most_tried && overlap(pair))
                    contact.kind = TriangleContact::crossing;
            }
            return contact.kind != TriangleContact::crossing && !planes_.part_all();
        };
        const auto touch_at_most = [&](TrianglePair pair) {
            if (planes_.part_all()) return false; // the test of this pair ends the traversal
            if (planes_.part(pair.a, pair.b)) return true;
            if (!corners_touch_at_most(pair)) return false;
            planes_.add_new(pair.a, pair.b);
            return !planes_.part_all();
        };
        contact.bound = walk_.meetings(a, b, b_to_a, hint, found, touch_at_most, place);
        contact.parted = planes_.part_all();
        return contact;
    }
}

/// Collects all pairs that meet, except pairs for which leave(pair) is true.
template <class A, class B>
template <class Leave>
void TraversalOf<A, B>::collect(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out, Leave leave)
{
    out.clear();
    walk_.all_meetings(
        a, b, b_to_a, [&](TrianglePair pair) { out.push_back(pair); }, leave);
    sort_pairs(out);
}

template <class A, class B>
void TraversalOf<A, B>::all_meeting(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out)
{
    collect(a, b, b_to_a, out, leave_none);
}

template <class A, class B>
void TraversalOf<A, B>::all_near(A& a, B& b, const RelativePose& b_to_a, double clearance,
                                 std::vector<TrianglePair>& out, std::vector<TrianglePair>* meeting)
{
    out.clear();
    walk_.all_near(a, b, b_to_a, clearance, [&](const TrianglePair& pair) { out.push_back(pair); });
    if (!meeting) return;
    meeting->clear();
    if (!out.empty()) walk_.leaves().meeting(out, [&](TrianglePair pair) { return meeting->push_back(pair), true; });
    sort_pairs(*meeting);
}

template <class A, class B>
void TraversalOf<A, B>::all_meeting(A& a, B& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out,
                                    CommonCorners& corners) requires two_meshes<A, B>
{
    if constexpr (two_meshes<A, B>) { // Clang 14 instantiates it regardless of the constraint
        corners.of_a.assign(a.mesh().triangles.size(), 0), corners.of_b.assign(b.mesh().triangles.size(), 0);
        const Tests& triangles = walk_.leaves();
        collect(a, b, b_to_a, out, [&](TrianglePair pair) {
            const auto corner = only_common_corner(triangles.points_a(pair.a), triangles.points_b(pair.b));
            if (!corner) return false;
            corners.of_a[pair.a] |= 1u << corner->a, corners.of_b[pair.b] |= 1u << corner->b;
            return true;
        });
    }
}

template <class A, class B>
typename TraversalOf<A, B>::Nearness TraversalOf<A, B>::near(A& a, B& b, const RelativePose& b_to_a, double clearance,
                                                             double tolerance, std::optional<TrianglePair> hint,
                                                             std::optional<Place>* place)
{
    return walk_.near(a, b, b_to_a, clearance, tolerance, hint, place);
}

template <class A, class B>
typename TraversalOf<A, B>::Distance TraversalOf<A, B>::distance(A& a, B& b, const RelativePose& b_to_a,
                                                                 double tolerance, double cutoff)
{
    return walk_.distance(a, b, b_to_a, tolerance, cutoff);
}

template class TraversalOf<ObbTree, ObbTree>;
template class TraversalOf<TerrainTree, ObbTree>;
template class TraversalOf<ObbTree, TerrainTree>;
template class TraversalOf<TerrainTree, TerrainTree>;

} // namespace oncollide
