#include <oncollide/narrowphase/boxes/traversal.hpp>

#include <algorithm>

#include <oncollide/narrowphase/boxes/traversal_steps.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>

namespace oncollide {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr auto none = [](TrianglePair) { return false; };

} // namespace

/// At least so far apart are meshes of which no two triangles met: by the gaps of boxes that were left, and of
/// triangles that were tested.
double Traversal::least_gap(const Query& query)
{
    double least = infinity;
    for (float gap : nearest_) least = std::min(least, double(gap) - query.rounding);
    for (double gap2 : nearest_triangles2_) least = std::min(least, std::sqrt(gap2) * (1 - 0x1p-50));
    for (const TrianglePair& pair : barely_apart_) {
        const TrianglePoints a = query.points_a(pair.a), b = query.points_b(pair.b);
        const double gap = triangle_distance(a, b) - query.triangle_rounding;
        least = std::min(least, gap > 0 ? gap : triangle_gap(a, b));
    }
    return least * (1 - 0x1p-18); // poses may be 2^-20 from rigid
}

/// found(pair) for those that meet, the hint's first, while it returns true. The hint may come twice. At least so far
/// are the meshes apart, if none meet.
/// @param leave  pairs of triangles that need not be tested
template <class Found, class Leave>
double Traversal::meetings(const Query& query, std::optional<TrianglePair> hint, Found found, Leave leave)
{
    if (query.apart > 0) return query.apart;
    bool met = false;
    const auto take = [&](TrianglePair pair) {
        met = true;
        return found(pair);
    };
    if (hint) {
        waiting_.assign(1, *hint);
        if (!test_waiting(query, take)) return 0;
    }
    bool go_on = true;
    std::size_t batch = first_batch;
    walk(query, static_cast<float>(query.rounding * (1 + 0x1p-20)), [&](const Entry& e) {
        each_pair(e, [&](TrianglePair pair) {
            if (!leave(pair)) waiting_.push_back(pair);
            return true;
        });
        return go_on = test_if_enough(query, batch, take);
    });
    if (go_on) test_waiting(query, take);
    return met ? 0 : least_gap(query);
}

Traversal::Meeting Traversal::first_meeting(ObbTree& a, ObbTree& b, const RelativePose& b_to_a,
                                            std::optional<TrianglePair> hint)
{
    Meeting meeting;
    meeting.bound = meetings(
        Query(a, b, b_to_a), hint,
        [&](TrianglePair pair) {
            meeting.pair = pair;
            return false;
        },
        none);
    return meeting;
}

Traversal::Contact Traversal::contact(ObbTree& a, ObbTree& b, const RelativePose& b_to_a,
                                      std::optional<TrianglePair> hint)
{
    const Query query(a, b, b_to_a);
    Contact contact;
    // Where two fans of n triangles touch n^2 pairs do, in one plane or in a point: one plane tells of all of them.
    std::size_t planes = 0;
    std::uint64_t looked = 0;
    const std::uint64_t most_looks = 8 * (a.mesh().vertices.size() + b.mesh().vertices.size());
    const auto parted = [&](TrianglePair pair) {
        const Triangle &of_a = query.triangles_a[pair.a], &of_b = query.triangles_b[pair.b];
        return std::any_of(planes_.begin(),
                           planes_.begin() + static_cast<std::ptrdiff_t>(std::min(planes, planes_.size())),
                           [&](PlaneSides& plane) { return plane.part(of_a, of_b); });
    };
    const auto add_planes = [&](TrianglePair pair) {
        for (const TrianglePoints& face : {query.points_a(pair.a), query.points_b(pair.b)}) {
            if (collinear(face[0], face[1], face[2])) continue;
            PlaneSides& plane = planes_[planes % planes_.size()];
            plane.start(face, a.mesh(), b.mesh(), b_to_a);
            if (!plane.part(query.triangles_a[pair.a], query.triangles_b[pair.b])) continue;
            ++planes;
            contact.parted = looked < most_looks && plane.part_all(looked);
            return;
        }
    };
    const auto found = [&](TrianglePair pair) {
        const TriangleContact how = triangle_contact(query.points_a(pair.a), query.points_b(pair.b));
        if (how > contact.kind) contact.pair = pair, contact.kind = how;
        if (how == TriangleContact::touching && !parted(pair)) add_planes(pair);
        return contact.kind != TriangleContact::crossing && !contact.parted;
    };
    contact.bound = meetings(query, hint, found, [&](TrianglePair pair) { return planes && parted(pair); });
    return contact;
}

void Traversal::all_meeting(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out)
{
    out.clear();
    meetings(
        Query(a, b, b_to_a), {},
        [&](TrianglePair pair) {
            out.push_back(pair);
            return true;
        },
        none);
    std::sort(out.begin(), out.end());
}

} // namespace oncollide
