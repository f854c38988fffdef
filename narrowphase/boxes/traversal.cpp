#include <oncollide/narrowphase/boxes/traversal.hpp>

#include <algorithm>

#include <oncollide/narrowphase/boxes/traversal_steps.hpp>

namespace oncollide {

/// found(pair) for those that meet, the hint's first, while it returns true. The hint may come twice.
template <class Found>
void Traversal::meetings(const Query& query, std::optional<TrianglePair> hint, Found found)
{
    if (query.apart > 0) return;
    if (hint) {
        waiting_.assign(1, *hint);
        if (!test_waiting(query, found)) return;
    }
    bool go_on = true;
    std::size_t batch = first_batch;
    walk(query, static_cast<float>(query.rounding * (1 + 0x1p-20)), [&](const Entry& e) {
        each_pair(e, [&](TrianglePair pair) {
            waiting_.push_back(pair);
            return true;
        });
        return go_on = test_if_enough(query, batch, found);
    });
    if (go_on) test_waiting(query, found);
}

std::optional<TrianglePair> Traversal::first_meeting(ObbTree& a, ObbTree& b, const RelativePose& b_to_a,
                                                     std::optional<TrianglePair> hint)
{
    std::optional<TrianglePair> meeting;
    meetings(Query(a, b, b_to_a), hint, [&](TrianglePair pair) {
        meeting = pair;
        return false;
    });
    return meeting;
}

std::optional<TrianglePair> Traversal::contact(ObbTree& a, ObbTree& b, const RelativePose& b_to_a,
                                               TriangleContact& contact, std::optional<TrianglePair> hint)
{
    const Query query(a, b, b_to_a);
    std::optional<TrianglePair> meeting;
    contact = TriangleContact::separate;
    meetings(query, hint, [&](TrianglePair pair) {
        const TriangleContact how = triangle_contact(query.points_a(pair.a), query.points_b(pair.b));
        if (how > contact) meeting = pair, contact = how;
        return contact != TriangleContact::crossing;
    });
    return meeting;
}

void Traversal::all_meeting(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, std::vector<TrianglePair>& out)
{
    out.clear();
    meetings(Query(a, b, b_to_a), {}, [&](TrianglePair pair) {
        out.push_back(pair);
        return true;
    });
    std::sort(out.begin(), out.end());
}

} // namespace oncollide
