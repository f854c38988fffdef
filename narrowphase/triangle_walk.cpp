#include <oncollide/narrowphase/triangle_walk.hpp>

#include <algorithm>

#include "triangle_walk_steps.hpp"

namespace oncollide {

/// found(pair) for those that meet, the hint's first, while it returns true. The hint may come twice.
template <class Found>
void TriangleWalk::meetings(const Query& query, std::optional<TriangleMeeting> hint, Found found)
{
    if (query.apart > 0) return;
    if (hint) {
        waiting_.assign(1, *hint);
        if (!test_waiting(query, found)) return;
    }
    bool go_on = true;
    std::size_t batch = first_batch;
    walk(query, static_cast<float>(query.rounding * (1 + 0x1p-20)), [&](const Entry& e) {
        each_pair(e, [&](TriangleMeeting pair) {
            waiting_.push_back(pair);
            return true;
        });
        return go_on = test_if_enough(query, batch, found);
    });
    if (go_on) test_waiting(query, found);
}

std::optional<TriangleMeeting> TriangleWalk::first_meeting(TriangleTree& a, TriangleTree& b, const IntoA& into_a,
                                                           std::optional<TriangleMeeting> hint)
{
    std::optional<TriangleMeeting> meeting;
    meetings(Query(a, b, into_a), hint, [&](TriangleMeeting pair) {
        meeting = pair;
        return false;
    });
    return meeting;
}

std::optional<TriangleMeeting> TriangleWalk::contact(TriangleTree& a, TriangleTree& b, const IntoA& into_a,
                                                     TriangleContact& contact, std::optional<TriangleMeeting> hint)
{
    const Query query(a, b, into_a);
    std::optional<TriangleMeeting> meeting;
    contact = TriangleContact::separate;
    meetings(query, hint, [&](TriangleMeeting pair) {
        const TriangleContact how = triangle_contact(query.points_a(pair.a), query.points_b(pair.b));
        if (how > contact) meeting = pair, contact = how;
        return contact != TriangleContact::crossing;
    });
    return meeting;
}

void TriangleWalk::all_meeting(TriangleTree& a, TriangleTree& b, const IntoA& into_a, std::vector<TriangleMeeting>& out)
{
    out.clear();
    meetings(Query(a, b, into_a), {}, [&](TriangleMeeting pair) {
        out.push_back(pair);
        return true;
    });
    std::sort(out.begin(), out.end());
}

} // namespace oncollide
