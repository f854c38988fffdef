#include <oncollide/narrowphase/triangle_walk.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <oncollide/narrowphase/triangle_distance.hpp>
#include <oncollide/narrowphase/triangle_kernel.hpp>

namespace oncollide {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t first_batch = 4, most_batch = 64; ///< pairs of triangles tested together

JudgePairs* judge()
{
    static JudgePairs* const kernel = choose(baseline::judge_pairs(), avx2::judge_pairs(), avx512::judge_pairs());
    return kernel;
}

} // namespace

struct TriangleWalk::Query {
    TriangleTree &a, &b;
    const IntoA& into_a;
    const Eigen::Vector3d *vertices_a, *vertices_b;
    const Triangle *triangles_a, *triangles_b;
    BoxPlacement place_b;
    double rounding;          ///< of gaps between boxes
    double triangle_rounding; ///< of distances of triangles
    double apart;             ///< of the balls around the meshes, at least

    /// Coordinates, in A's tree's frame, are at most m = |d| + rA + rB. With u = 2^-24: floats of the placement and of
    /// centres and axes moved by it err by at most 50 u m along any axis of the test; the relative pose may be 2^-19 =
    /// 32 u from a rotation (two poses, each 2^-20), by which a box's own axes are not square: 4 * 32 u of its
    /// half-extents, summed to at most sqrt 2 r. Together below 256 u m. IntoA rounds in double, relative to the files'
    /// origins and to the bodies' distance.
    Query(TriangleTree& tree_a, TriangleTree& tree_b, const IntoA& into)
        : a(tree_a), b(tree_b), into_a(into), vertices_a(a.mesh().vertices.data()),
          vertices_b(b.mesh().vertices.data()), triangles_a(a.mesh().triangles.data()),
          triangles_b(b.mesh().triangles.data())
    {
        const Eigen::Vector3d d = into_a(b.centre()) - a.centre();
        for (int i = 0; i < 9; ++i) place_b.turn[i] = static_cast<float>(into_a.turn(i / 3, i % 3));
        for (int i = 0; i < 3; ++i) place_b.shift[i] = static_cast<float>(d[i]);
        const double both = a.radius() + b.radius(), m = d.norm() + both;
        const double far = a.centre().norm() + b.centre().norm() + into_a.shift.norm();
        rounding = 0x1p-16 * m + 0x1p-48 * far + 1e-30;
        triangle_rounding = 0x1p-38 * m + 1e-150; // squares of less underflow
        apart = d.norm() - both - rounding;
    }

    TrianglePoints points_a(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_a[triangle];
        return {vertices_a[t[0]], vertices_a[t[1]], vertices_a[t[2]]};
    }
    TrianglePoints points_b(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_b[triangle];
        return {into_a(vertices_b[t[0]]), into_a(vertices_b[t[1]]), into_a(vertices_b[t[2]])};
    }
};

void TriangleWalk::start(const Query& query)
{
    a_.start(query.a, nullptr), b_.start(query.b, &query.place_b);
    stack_.clear(), waiting_.clear();
    std::fill(std::begin(nearest_), std::end(nearest_), std::numeric_limits<float>::infinity());
    stack_.push_back({0, 0, 0, 0, 0});
}

inline bool TriangleWalk::both_leaves(const Entry& e) const
{
    return a_[e.a].leaf(e.lane_a) && b_[e.b].leaf(e.lane_b);
}

/// Of the triangles in two leaves, while visit(pair) returns true. False when it did not.
template <class Visit>
bool TriangleWalk::each_pair(const Entry& e, Visit visit) const
{
    const BoxNode &a = *a_[e.a].node, &b = *b_[e.b].node;
    for (std::uint32_t i = 0; i < a.count[e.lane_a]; ++i)
        for (std::uint32_t j = 0; j < b.count[e.lane_b]; ++j)
            if (!visit(TriangleMeeting{a_.tree().triangle(a.begin[e.lane_a] + i),
                                       b_.tree().triangle(b.begin[e.lane_b] + j)}))
                return false;
    return true;
}

/// Opens the larger box; pushes its parts within `reach` of the other, the nearest last. Returns how many.
template <bool far>
inline unsigned TriangleWalk::open(const Entry& e, float reach)
{
    const bool down_a =
        b_[e.b].single(e.lane_b) || (!a_[e.a].single(e.lane_a) && a_[e.a].size(e.lane_a) >= b_[e.b].size(e.lane_b));
    const std::uint32_t slot = down_a ? a_.descend(e.a, e.lane_a) : b_.descend(e.b, e.lane_b);
    const OpenBoxes &boxes = (down_a ? a_[slot] : b_[slot]).boxes, &other = (down_a ? b_[e.b] : a_[e.a]).boxes;
    ++counts_.box_rows;
    float gaps[8];
    const auto compare = far ? oriented_box_kernel().compare_far : oriented_box_kernel().compare;
    unsigned near = compare(boxes, other, down_a ? e.lane_b : e.lane_a, reach, gaps, nearest_);
    if (!near) return 0;
    const std::size_t first = stack_.size();
    stack_.resize(first + 8); // lets go of what is too much below
    Entry *out = &stack_[first], *nearest = out;
    Entry child = e;
    for (; near; near &= near - 1, ++out) {
        const auto k = static_cast<std::uint8_t>(__builtin_ctz(near));
        (down_a ? child.a : child.b) = slot;
        (down_a ? child.lane_a : child.lane_b) = k;
        child.gap = gaps[k];
        *out = child;
        if (child.gap < nearest->gap) nearest = out;
    }
    std::swap(*nearest, out[-1]);
    const auto count = static_cast<unsigned>(out - &stack_[first]);
    stack_.resize(first + count);
    return count;
}

/// Depth first; take_leaves(entry) for leaves within `reach`, while it returns true.
template <class TakeLeaves>
void TriangleWalk::walk(const Query& query, float reach, TakeLeaves take_leaves)
{
    start(query);
    while (!stack_.empty()) {
        const Entry e = stack_.back();
        stack_.pop_back();
        if (!both_leaves(e))
            open<false>(e, reach);
        else if (!take_leaves(e))
            return;
    }
}

/// found(pair) for those that meet, while it returns true. False when it did not.
template <class Found>
bool TriangleWalk::test_waiting(const Query& query, Found found)
{
    bool go_on = true;
    for (std::size_t first = 0; first < waiting_.size() && go_on; first += 8) {
        const auto count = static_cast<unsigned>(std::min<std::size_t>(8, waiting_.size() - first));
        CornersOfPairs corners;
        for (unsigned i = 0; i < 8; ++i) { // places past the last pair hold it once more
            const TriangleMeeting& pair = waiting_[first + std::min(i, count - 1)];
            for (std::size_t k = 0; k < 3; ++k) {
                corners.a[k][i] = query.vertices_a[query.triangles_a[pair.a][k]].data();
                corners.b[k][i] = query.vertices_b[query.triangles_b[pair.b][k]].data();
            }
        }
        const PairVerdicts verdicts = judge()(corners, query.into_a.turn.data(), query.into_a.shift.data());
        counts_.triangles += count;
        for (unsigned rest = ~verdicts.separate & ((1u << count) - 1); rest && go_on; rest &= rest - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(rest));
            const TriangleMeeting pair = waiting_[first + i];
            bool meet = verdicts.known >> i & 1;
            if (!meet) ++counts_.unsure, meet = triangles_meet(query.points_a(pair.a), query.points_b(pair.b));
            if (meet) go_on = found(pair);
        }
    }
    waiting_.clear();
    return go_on;
}

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
        if (waiting_.size() < batch) return true;
        batch = std::min(2 * batch, most_batch);
        return go_on = test_waiting(query, found);
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

TriangleWalk::Nearness TriangleWalk::near(TriangleTree& a, TriangleTree& b, const IntoA& into_a, double clearance,
                                          double tolerance, std::optional<TriangleMeeting> hint)
{
    const Query query(a, b, into_a);
    // Poses may be 2^-20 from rigid: so far may a distance in A's frame be from that in the world.
    const double rounding = query.triangle_rounding + 0x1p-18 * clearance;
    Nearness answer{false, clearance + std::max(tolerance, 2 * rounding), {}};
    const double enough = answer.bound - rounding;
    if (query.apart > clearance) return {false, query.apart, {}};
    const auto take = [&](TriangleMeeting pair) {
        answer.near = true, answer.meeting = pair;
        return false;
    };
    if (hint) {
        waiting_.assign(1, *hint);
        if (!test_waiting(query, take)) return answer;
    }
    double lower = infinity; // of triangles that were left
    const auto take_pair = [&](TriangleMeeting pair, bool small) {
        if (clearance == 0 && !small) {
            lower = 0;
            waiting_.push_back(pair);
            return true;
        }
        const TrianglePoints of_a = query.points_a(pair.a), of_b = query.points_b(pair.b);
        if (corner_distance(of_a, of_b) <= enough) answer.near = true;
        if (answer.near) return false;
        if (clearance == 0) {
            lower = 0;
            waiting_.push_back(pair);
            return true;
        }
        ++counts_.triangles;
        const double distance = triangle_distance(of_a, of_b);
        answer.near = distance - rounding <= clearance || triangles_meet(of_a, of_b);
        lower = std::min(lower, distance - rounding);
        return !answer.near;
    };
    std::size_t batch = first_batch;
    const double reach = (clearance + query.rounding) * (1 + 0x1p-20);
    walk(query, static_cast<float>(reach), [&](const Entry& e) {
        const float size2 = a_[e.a].size(e.lane_a) + b_[e.b].size(e.lane_b);
        const bool small = double(size2) <= 16 * enough * enough; // else their corners are hardly so near
        if (!each_pair(e, [&](TriangleMeeting pair) { return take_pair(pair, small); })) return false;
        if (waiting_.size() < batch) return true;
        batch = std::min(2 * batch, most_batch);
        return test_waiting(query, take);
    });
    if (answer.near || !test_waiting(query, take)) return answer;
    for (float gap : nearest_) lower = std::min(lower, double(gap) - query.rounding);
    return {false, std::max(lower * (1 - 0x1p-18), clearance), {}};
}

TriangleWalk::Distance TriangleWalk::distance(TriangleTree& a, TriangleTree& b, const IntoA& into_a, double tolerance,
                                              double farthest)
{
    const Query query(a, b, into_a);
    if (query.apart > farthest) return {query.apart, infinity, {}};
    Distance best{infinity, infinity, {}};
    const auto take_pair = [&](TriangleMeeting pair) {
        const TrianglePoints of_a = query.points_a(pair.a), of_b = query.points_b(pair.b);
        ++counts_.triangles;
        if (triangles_meet(of_a, of_b)) {
            best = {0, 0, pair};
            return false;
        }
        const double distance = triangle_distance(of_a, of_b), upper = distance + query.triangle_rounding;
        best.lower = std::min(best.lower, distance - query.triangle_rounding);
        if (upper < best.upper && upper <= farthest) best.upper = upper, best.nearest = pair;
        return true;
    };
    const auto farther = [](const Entry& x, const Entry& y) { return x.gap > y.gap; };
    start(query);
    while (!stack_.empty()) {
        const Entry e = stack_.front(); // of a heap: the least gap
        const double reach = std::min(std::min(best.upper - tolerance, farthest) + query.rounding, 0x1p90);
        if (e.gap > reach) {
            best.lower = std::min(best.lower, e.gap - query.rounding);
            break;
        }
        std::pop_heap(stack_.begin(), stack_.end(), farther);
        stack_.pop_back();
        if (both_leaves(e)) {
            if (!each_pair(e, take_pair)) return best;
            continue;
        }
        for (unsigned added = open<true>(e, static_cast<float>(reach)); added-- > 0;)
            std::push_heap(stack_.begin(), stack_.end() - static_cast<std::ptrdiff_t>(added), farther);
    }
    for (float gap : nearest_) best.lower = std::min(best.lower, double(gap) - query.rounding);
    best.lower = std::max(best.lower, 0.0);
    return best;
}

} // namespace oncollide
