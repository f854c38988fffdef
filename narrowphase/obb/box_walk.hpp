// Traversal of two hierarchies of oriented boxes: the larger box first, the deepest overlap first. All queries on boxes
// are built from these steps.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/obb/open_nodes.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>
#include <oncollide/narrowphase/obb/walk_frame.hpp>

namespace oncollide {

/// Bounds on a distance.
template <class Pair>
struct DistanceBounds {
    double lower, upper;         ///< both 0 if the geometries were found to meet
    std::optional<Pair> nearest; ///< two primitives at the distance `upper`, or that meet
};

/// How a distance compares with a cutoff.
template <class Pair>
struct Comparison {
    int sign; ///< -1: the distance is at most the cutoff; 1: it is more; 0: it differs from the cutoff by no more than
              ///< rounding
    double bound; ///< sign 1: a lower bound of the distance, above the cutoff; else an upper bound, for sign 0 at least
                  ///< the cutoff
    std::optional<Pair> witness; ///< sign -1: two primitives at most the cutoff apart
};

template <class Pair>
struct NearBounds {
    bool near;
    double bound; ///< near: upper bound of the distance, clearance + tolerance (or + rounding, if that is more); else
                  ///< lower bound, at least the clearance; > 0 unless doubles cannot express it
    std::optional<Pair> witness; ///< near: two primitives within `bound`
};

/// Two boxes around the primitives that met last, some levels above them: box `lane` of a node on each side.
template <BoxHierarchy A, BoxHierarchy B>
struct MeetingHint {
    typename A::Node a;
    typename B::Node b;
    std::uint8_t lane_a, lane_b;
    std::uint32_t of_a, of_b; ///< identity() of the hierarchies, if they store nodes

    MeetingHint(const A& in_a, const typename A::Node& at_a, std::uint8_t k_a, const B& in_b,
                 const typename B::Node& at_b, std::uint8_t k_b)
        : a(at_a), b(at_b), lane_a(k_a), lane_b(k_b), of_a(identity(in_a)), of_b(identity(in_b))
    {
    }
    bool holds_in(const A& in_a, const B& in_b) const { return of_a == identity(in_a) && of_b == identity(in_b); }

private:
    static std::uint32_t identity(const auto& hierarchy)
    {
        if constexpr (requires { hierarchy.identity(); })
            return hierarchy.identity();
        else
            return 0;
    }
};

/// The queries about two hierarchies. One thread's working memory; other threads may traverse the same hierarchies
/// meanwhile. Distances are metres. A hint is two primitives that met last: they are tested first.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
class BoxWalk {
public:
    using Pair = typename Leaves::Pair;
    using Place = MeetingHint<A, B>;

    /// Calls found(pair) for primitives that meet, the hint's first, while it returns true. The hint may come twice.
    /// Returns a lower bound of the distance if none meet; else 0.
    /// @param leave  leave(pair) is true for pairs that need not be tested
    /// @param place  where primitives met last; tested before the rest. Set to where they meet
    double meetings(A& a, B& b, const RelativePose& b_to_a, std::optional<Pair> hint, auto found, auto leave,
                    std::optional<Place>* place = nullptr);

    /// Calls found(pair) once for each pair of primitives that meet, in any order, except pairs for which leave(pair)
    /// is true. Defined in box_walk_all.hpp.
    void all_meetings(A& a, B& b, const RelativePose& b_to_a, auto found, auto leave);

    /// Decides whether the distance is at most `clearance`. Geometries farther apart than the clearance, but at most
    /// clearance + tolerance apart, may be reported as near. Whether they are does not depend on `hint`.
    NearBounds<Pair> near(A& a, B& b, const RelativePose& b_to_a, double clearance, double tolerance,
                          std::optional<Pair> hint, std::optional<Place>* place = nullptr);

    /// Decides whether the distance, in A's frame, is at most `cutoff`. A hint is two primitives that were that near.
    /// @param slack  error bound of the caller's cutoff, besides rounding
    Comparison<Pair> compare(A& a, B& b, const RelativePose& b_to_a, double cutoff, double slack,
                             std::optional<Pair> hint);

    /// Bounds of the distance, at most `tolerance` plus rounding apart. Depth first, the nearest boxes first. Beyond
    /// the cutoff `farthest`: lower > cutoff, upper = inf. Otherwise both are finite.
    DistanceBounds<Pair> distance(A& a, B& b, const RelativePose& b_to_a, double tolerance, double farthest);

    Leaves& leaves() { return leaves_; }
    const Leaves& leaves() const { return leaves_; }
    /// True if, in the last query other than distance(), no box of A came within the cutoff of B's root box.
    bool far_from_all() const { return far_; }
    std::uint64_t box_rows = 0;   ///< tests of one box against all boxes of a node
    std::uint64_t hints_held = 0; ///< queries that their hint or place decided

private:
    /// A pair of boxes, one of an open node on each side. Packed in one word because the traversal soon reads it back:
    /// a load that spans several recent stores stalls the processor.
    struct Entry {
        std::uint64_t boxes = 0; ///< 8 * slot + lane; B's in the upper half
        float gap = 0;

        Entry() = default;
        Entry(std::uint32_t slot_a, std::uint32_t lane_a, std::uint32_t slot_b, std::uint32_t lane_b)
            : boxes(8 * slot_a + lane_a + (std::uint64_t(8 * slot_b + lane_b) << 32))
        {
        }
        std::uint32_t slot_a() const { return static_cast<std::uint32_t>(boxes) / 8; }
        std::uint32_t slot_b() const { return static_cast<std::uint32_t>(boxes >> 35); }
        std::uint8_t lane_a() const { return boxes & 7; }
        std::uint8_t lane_b() const { return boxes >> 32 & 7; }
    };
    static constexpr std::size_t first_batch = 4, most_batch = 64; ///< pairs of primitives tested together
    /// True if measuring several pairs costs little more than measuring one.
    static constexpr bool measures_many = requires(Leaves & leaves, std::span<const Pair> pairs)
    {
        leaves.nearest(pairs, [](const Pair&, const NearestPoints&) {});
    };
    static constexpr std::size_t measured = measures_many ? 4 : 1, most_seeds = 2 * measured;
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    static constexpr double box_line_length = 1 - 0x1p-20;

    void begin(A& a, B& b, const RelativePose& b_to_a, const WalkFrame& frame, const typename B::Node& of_b = B::root)
    {
        a_.start(a, &frame.place_a), b_.start(b, &frame.place_b);
        leaves_.start(a, b, b_to_a);
        waiting_.clear(), from_.clear();
        if (stack_.empty()) stack_.resize(64);
        b_.open(of_b);
        reset();
    }
    void reset()
    {
        std::fill(std::begin(nearest_), std::end(nearest_), std::numeric_limits<float>::infinity());
        top_ = 0, far_ = false;
    }
    void start(A& a, B& b, const RelativePose& b_to_a, const WalkFrame& frame)
    {
        begin(a, b, b_to_a, frame);
        a_.open(A::root);
        start_again();
    }
    /// Starts again from the roots; open nodes stay open.
    void start_again()
    {
        reset();
        stack_[top_++] = {};
    }
    /// As start(), for primitives within `cutoff`: of a large geometry only the surroundings of the other one.
    void start_near(A& a, B& b, const RelativePose& b_to_a, const WalkFrame& frame, double cutoff)
    {
        const auto around = [&](const Eigen::Vector3d& centre, double radius) {
            const double out = radius * (1 + 0x1p-18) + cutoff + 2 * frame.box_rounding;
            return Aabb{centre.array() - out, centre.array() + out};
        };
        const auto of_b = entry(b, [&] {
            const Eigen::Vector3d between = a.centre() - b_to_a(b.centre());
            return around(b.centre() + b_to_a.rotation.transpose() * between, a.radius());
        });
        begin(a, b, b_to_a, frame, of_b.node.value_or(B::root));
        double gap = of_b.gap;
        if constexpr (requires(const Aabb& box) { a.starts(box, 0.0, starts_); }) {
            const OpenBoxes& root = b_[0].boxes;
            Aabb box;
            for (int i = 0; i < 3; ++i) {
                double half = (cutoff + 2 * frame.box_rounding) * (1 + 0x1p-16) + root.margin;
                for (int j = 0; j < 3; ++j) half += std::abs(double(root.axis[j][i][0])) * root.h[j][0];
                const double centre = frame.origin[i] + root.c[i][0];
                box.min[i] = centre - half, box.max[i] = centre + half;
            }
            const float far = frame.gap_within(cutoff);
            gap = std::min(gap, a.starts(box, root.size[0], starts_));
            for (const typename A::Node& node : starts_) compare<false>({}, true, a_.open(node), far);
        } else {
            const auto of_a = entry(a, [&] { return around(b_to_a(b.centre()), b.radius()); });
            a_.open(of_a.node.value_or(A::root));
            gap = std::min(gap, of_a.gap);
            if (of_a.node) stack_[top_++] = {};
        }
        nearest_[0] = std::min(nearest_[0], static_cast<float>(cutoff + gap));
        if (!of_b.node) top_ = 0;
        far_ = top_ == 0;
    }
    /// The node from which to search for the contents of box(): the root unless the hierarchy has entry().
    template <class Hierarchy>
    static auto entry(const Hierarchy& hierarchy, auto box)
    {
        if constexpr (requires(const Aabb& b) { hierarchy.entry(b); }) {
            return hierarchy.entry(box());
        } else {
            struct Entry {
                std::optional<typename Hierarchy::Node> node;
                double gap;
            };
            return Entry{Hierarchy::root, infinity};
        }
    }
    /// True if the primitive of a hint is loaded; a geometry that is read on demand may have dropped it.
    static bool holds(const auto& hierarchy, const auto& primitive)
    {
        if constexpr (requires { hierarchy.holds(primitive); })
            return hierarchy.holds(primitive);
        else
            return true;
    }
    /// Tests the hint; called before start(), so that a hint that does not meet leaves no state. False: the query ends.
    bool go_on_after_hint(A& a, B& b, const RelativePose& b_to_a, const std::optional<Pair>& hint, auto found)
    {
        waiting_.clear(), from_.clear();
        if (!hint || !holds(a, hint->a) || !holds(b, hint->b)) return true;
        leaves_.start(a, b, b_to_a);
        return leaves_.meeting(std::span<const Pair>(&*hint, 1), found);
    }
    /// As go_on_after_hint(), for the primitives around the last place.
    bool go_on_after_place(A& a, B& b, const RelativePose& b_to_a, const WalkFrame& frame, std::optional<Place>* place,
                           auto found, auto leave)
    {
        if (!place || !*place || !(*place)->holds_in(a, b)) return true;
        begin(a, b, b_to_a, frame, (*place)->b);
        a_.open((*place)->a);
        stack_[top_++] = {0, (*place)->lane_a, 0, (*place)->lane_b};
        std::size_t batch = first_batch;
        bool go_on = true;
        walk(frame.gap_within(0), [&](Entry e) {
            wait(e, leave);
            return go_on = test_if_enough(batch, found);
        });
        return go_on && test_waiting(found);
    }
    void wait(Entry e, auto leave)
    {
        each_pair(e, [&](Pair pair) {
            if (!leave(pair)) waiting_.push_back(pair), from_.push_back(e);
            return true;
        });
    }
    /// Sets the place around the pair, which waited or is in the boxes of an entry.
    void set_place(const A& a, const B& b, std::optional<Place>* place, const Pair& pair, const Entry* from = nullptr)
    {
        constexpr int levels = 2; // up to a hundred triangles: mostly they meet there again, for a quarter of the cost
                                  // of a traversal
        if (!place) return;
        for (std::size_t i = 0; i < from_.size(); ++i)
            if (waiting_[i].a == pair.a && waiting_[i].b == pair.b) from = &from_[i];
        if (!from) return; // the pair is the hint
        const auto [slot_a, lane_a] = a_.up(from->slot_a(), from->lane_a(), levels);
        const auto [slot_b, lane_b] = b_.up(from->slot_b(), from->lane_b(), levels);
        place->emplace(a, a_[slot_a].node, lane_a, b, b_[slot_b].node, lane_b);
    }
    bool both_leaves(Entry e) const { return a_[e.slot_a()].leaf(e.lane_a()) && b_[e.slot_b()].leaf(e.lane_b()); }
    /// True if the box of A is to be opened: the larger box is, unless it is single.
    bool opens_a(Entry e) const
    {
        return b_[e.slot_b()].single(e.lane_b()) ||
               (!a_[e.slot_a()].single(e.lane_a()) &&
                a_[e.slot_a()].size(e.lane_a()) >= b_[e.slot_b()].size(e.lane_b()));
    }
    bool each_pair(Entry e, auto visit) const;
    template <bool far>
    unsigned open(Entry e, float cutoff);
    template <bool far>
    unsigned compare(Entry e, bool down_a, std::uint32_t slot, float cutoff);
    /// A direction in A's frame and in B's, of length 1 at most. The projection of a point of B in A's frame is its
    /// projection in B's frame plus `shift`.
    struct Line {
        Eigen::Vector3d in_a, in_b;
        double shift;

        Line() : Line(Eigen::Vector3d::Zero(), {Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()}) {}
        Line(const Eigen::Vector3d& between, const RelativePose& b_to_a)
        {
            const double length = between.norm() * (1 + 0x1p-50);
            in_a = length > 0 ? Eigen::Vector3d(between / length) : Eigen::Vector3d(Eigen::Vector3d::Zero());
            in_b = b_to_a.rotation.transpose() * in_a, shift = in_a.dot(b_to_a.translation);
        }
    };
    double high_a(const auto& of_a, const Line& line) const
    {
        double high = -infinity;
        for (const auto a : of_a) high = std::max(high, leaves_.high_a(a, line.in_a));
        return high;
    }
    double low_b(const auto& of_b, const Line& line) const
    {
        double low = infinity;
        for (const auto b : of_b) low = std::min(low, leaves_.low_b(b, line.in_b));
        return low + line.shift;
    }
    /// Sets the direction onto which boxes are also projected.
    void take_line(const Line& line)
    {
        line_ = line, origin_along_line_ = line.in_a.dot(origin_);
        for (int i = 0; i < 3; ++i) toward_b_[i] = static_cast<float>(box_line_length * line.in_a[i]);
    }
    /// Sets the direction from the other box towards the parts of this one, and the other box's largest projection onto
    /// it. If the other box is a leaf, its primitives are projected instead.
    void set_line(BoxLine& line, Entry e, bool down_a) const
    {
        for (int i = 0; i < 3; ++i) line.direction[i] = down_a ? -toward_b_[i] : toward_b_[i];
        if (down_a ? b_[e.slot_b()].leaf(e.lane_b()) : a_[e.slot_a()].leaf(e.lane_a())) {
            const double reach = down_a ? origin_along_line_ - low_b(b_.primitives(e.slot_b(), e.lane_b()), line_)
                                        : high_a(a_.primitives(e.slot_a(), e.lane_a()), line_) - origin_along_line_;
            line.other_reach = static_cast<float>(box_line_length * reach);
            return;
        }
        const OpenBoxes& boxes = down_a ? b_[e.slot_b()].boxes : a_[e.slot_a()].boxes;
        const unsigned k = down_a ? e.lane_b() : e.lane_a();
        const auto along = [&](const auto& v) {
            return line.direction[0] * v[0][k] + line.direction[1] * v[1][k] + line.direction[2] * v[2][k];
        };
        float reach = along(boxes.c);
        for (int i = 0; i < 3; ++i) reach += boxes.h[i][k] * std::abs(along(boxes.axis[i]));
        line.other_reach = reach;
    }
    /// Sorts the last `count` entries, at most eight, so that the nearest is last.
    void sort_last(unsigned count)
    {
        Entry* const first = &stack_[top_ - count];
        for (unsigned i = 1; i < count; ++i) {
            const Entry e = first[i];
            unsigned k = i;
            for (; k > 0 && first[k - 1].gap < e.gap; --k) first[k] = first[k - 1];
            first[k] = e;
        }
    }
    void walk(float cutoff, auto take_leaves);
    void walk_all(float cutoff, auto take_leaves);
    bool test_waiting(auto found)
    {
        const bool go_on = leaves_.meeting(std::span<const Pair>(waiting_), found);
        waiting_.clear(), from_.clear();
        return go_on;
    }
    bool test_if_enough(std::size_t& batch, auto found);
    /// Bounds of the distance of primitives that do not meet, and the vector from A's nearest point to B's.
    struct Nearest {
        double lower, upper;
        Eigen::Vector3d between;
    };
    Nearest nearest(const Pair& pair, const WalkFrame& frame)
    {
        if constexpr (requires { leaves_.bounds(pair); }) {
            const auto found = leaves_.bounds(pair);
            return {found.lower, found.upper, found.on_b - found.on_a};
        } else {
            const NearestPoints found = leaves_.nearest(pair);
            return {found.distance - frame.leaf_rounding, found.distance + frame.leaf_rounding, found.b - found.a};
        }
    }
    /// Calls take(pair, points) for all waiting pairs.
    void measure_waiting(const WalkFrame& frame, auto take)
    {
        if constexpr (measures_many) {
            leaves_.nearest(std::span<const Pair>(waiting_), [&](const Pair& pair, const NearestPoints& found) {
                take(pair, Nearest{found.distance - frame.leaf_rounding, found.distance + frame.leaf_rounding,
                                   found.b - found.a});
            });
        } else {
            for (const Pair& pair : waiting_) take(pair, nearest(pair, frame));
        }
        waiting_.clear();
    }
    double least_box_gap(const WalkFrame& frame) const
    {
        double least = infinity;
        for (const float gap : nearest_) least = std::min(least, frame.at_least(gap));
        return least;
    }
    /// Lower bound of the distance if no two primitives met, from the rejected boxes and the tested primitives.
    double least_gap(const WalkFrame& frame)
    {
        const double least = std::min(least_box_gap(frame), leaves_.least_gap(frame.leaf_rounding));
        return least * (1 - 0x1p-18); // poses may be 2^-20 from rigid
    }

    const OrientedBoxKernel kernel_ = oriented_box_kernel();
    OpenNodes<A> a_;
    OpenNodes<B> b_;
    std::vector<Entry> stack_; ///< the first top_ entries are in use
    std::size_t top_ = 0;
    bool far_ = true;
    std::vector<typename A::Node> starts_;
    std::vector<Pair> waiting_;    ///< pairs to be tested together
    std::vector<Entry> from_;      ///< the boxes that contain them
    alignas(32) float nearest_[8]; ///< least gaps of the rejected boxes
    Eigen::Vector3d origin_;       ///< of the boxes' coordinates, in A's frame
    Line line_;                    ///< from A's nearest point found so far to B's
    double origin_along_line_;
    float toward_b_[3]; ///< line_ for boxes: a little shorter, so that rounding makes it no longer than 1
    Leaves leaves_;
};

/// Calls visit(pair) for the primitives in two leaves while it returns true. Returns whether it always did.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
bool BoxWalk<A, B, Leaves>::each_pair(Entry e, auto visit) const
{
    const auto of_b = b_.primitives(e.slot_b(), e.lane_b());
    for (const auto a : a_.primitives(e.slot_a(), e.lane_a()))
        for (const auto b : of_b)
            if (!visit(Pair{a, b})) return false;
    return true;
}

/// Opens the larger box, and compares its parts with the other box.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
template <bool far>
unsigned BoxWalk<A, B, Leaves>::open(Entry e, float cutoff)
{
    const bool down_a = opens_a(e);
    return compare<far>(e, down_a, down_a ? a_.descend(e.slot_a(), e.lane_a()) : b_.descend(e.slot_b(), e.lane_b()),
                        cutoff);
}

/// Pushes the boxes of the node in the slot, of A or of B, that are within `cutoff` of the other box, the nearest last.
/// Returns how many.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
template <bool far>
unsigned BoxWalk<A, B, Leaves>::compare(Entry e, bool down_a, std::uint32_t slot, float cutoff)
{
    const OpenBoxes &boxes = down_a ? a_[slot].boxes : b_[slot].boxes,
                    &other = down_a ? b_[e.slot_b()].boxes : a_[e.slot_a()].boxes;
    ++box_rows;
    float gaps[8];
    const unsigned k = down_a ? e.lane_b() : e.lane_a();
    if (down_a) // as a rule the other box is soon the larger one
        b_.prefetch(e.slot_b(), k);
    else
        a_.prefetch(e.slot_a(), k);
    unsigned near;
    if constexpr (far) {
        BoxLine line;
        set_line(line, e, down_a);
        near = kernel_.compare_far(boxes, other, k, line, cutoff, gaps, nearest_);
    } else {
        near = kernel_.compare(boxes, other, k, cutoff, gaps, nearest_);
    }
    if (!near) return 0;
    const unsigned found = near;
    if (stack_.size() < top_ + 8) stack_.resize(2 * (top_ + 8));
    Entry* const first = &stack_[top_];
    const Entry part = down_a ? Entry(slot, 0, e.slot_b(), k) : Entry(e.slot_a(), k, slot, 0); // box 0 of the node
    Entry *out = first, child, nearest;
    for (bool any = false; near; near &= near - 1, any = true) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(near));
        child.boxes = part.boxes + (std::uint64_t{lane} << (down_a ? 0 : 32));
        child.gap = gaps[lane];
        if (!any) {
            nearest = child;
        } else if (child.gap < nearest.gap) {
            *out++ = nearest;
            nearest = child;
        } else {
            *out++ = child;
        }
    }
    *out++ = nearest;
    const auto count = static_cast<unsigned>(out - first);
    down_a ? a_.prefetch_below(slot, found) : b_.prefetch_below(slot, found);
    top_ += count;
    return count;
}

/// Depth first: calls take_leaves(entry) for pairs of leaves within `cutoff`, while it returns true.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
void BoxWalk<A, B, Leaves>::walk(float cutoff, auto take_leaves)
{
    while (top_) {
        const Entry e = stack_[--top_];
        if (!both_leaves(e))
            open<false>(e, cutoff);
        else if (!take_leaves(e))
            return;
    }
}

/// Calls test_waiting() once `batch` pairs wait, and doubles the batch: a first meeting is likely among the first
/// pairs.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
bool BoxWalk<A, B, Leaves>::test_if_enough(std::size_t& batch, auto found)
{
    if (waiting_.size() < batch) return true;
    batch = std::min(2 * batch, most_batch);
    return test_waiting(found);
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
double BoxWalk<A, B, Leaves>::meetings(A& a, B& b, const RelativePose& b_to_a, std::optional<Pair> hint, auto found,
                                       auto leave, std::optional<Place>* place)
{
    const WalkFrame frame(a, b, b_to_a);
    far_ = true;
    if (frame.apart > 0) return frame.apart;
    bool met = false, go_on = true;
    const auto take = [&](Pair pair) {
        met = true;
        set_place(a, b, place, pair);
        return found(pair);
    };
    if (!go_on_after_hint(a, b, b_to_a, hint, take)) return ++hints_held, 0;
    if (!go_on_after_place(a, b, b_to_a, frame, place, take, leave)) return ++hints_held, 0;
    std::size_t batch = first_batch;
    start_near(a, b, b_to_a, frame, 0);
    walk(frame.gap_within(0), [&](Entry e) {
        wait(e, leave);
        return go_on = test_if_enough(batch, take);
    });
    if (go_on) test_waiting(take);
    return met ? 0 : least_gap(frame);
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
NearBounds<typename Leaves::Pair> BoxWalk<A, B, Leaves>::near(A& a, B& b, const RelativePose& b_to_a, double clearance,
                                                              double tolerance, std::optional<Pair> hint,
                                                              std::optional<Place>* place)
{
    const WalkFrame frame(a, b, b_to_a);
    // Poses may be 2^-20 from rigid, so a distance in A's frame may differ from the distance in the world frame.
    const double rounding = frame.leaf_rounding + 0x1p-18 * clearance;
    NearBounds<Pair> result{false, clearance + std::max(tolerance, 2 * rounding), {}};
    const double enough = result.bound - rounding;
    far_ = true;
    if (frame.apart > clearance) return {false, frame.apart, {}};
    const Entry* from = nullptr; // the entry of pairs that do not wait
    const auto take = [&](Pair pair) {
        result.near = true, result.witness = pair;
        set_place(a, b, place, pair, from);
        return false;
    };
    if (!go_on_after_hint(a, b, b_to_a, hint, take)) return ++hints_held, result;
    if (!go_on_after_place(a, b, b_to_a, frame, place, take, [](const Pair&) { return false; }))
        return ++hints_held, result;
    double lower = infinity; // lower bound over primitives that do not wait
    const auto take_pair = [&](Pair pair, bool small) {
        if (small || clearance > 0) {
            if (leaves_.most(pair) <= enough) return take(pair);
            if (clearance > 0) {
                const Nearest found = nearest(pair, frame);
                const double least = found.lower - 0x1p-18 * clearance;
                if (least <= clearance) {
                    // If only bounds of a pair are known, its distance may be larger than rounding explains.
                    if constexpr (requires { leaves_.bounds(pair); })
                        result.bound = std::max(result.bound, found.upper);
                    return take(pair);
                }
                if (leaves_.meet(pair)) return take(pair);
                lower = std::min(lower, least);
                return true;
            }
        }
        waiting_.push_back(pair), from_.push_back(*from);
        return true;
    };
    std::size_t batch = first_batch;
    start_near(a, b, b_to_a, frame, clearance);
    walk(frame.gap_within(clearance), [&](Entry e) {
        const float size2 = a_[e.slot_a()].size(e.lane_a()) + b_[e.slot_b()].size(e.lane_b());
        const bool small = double(size2) <= 16 * enough * enough; // otherwise their corners are rarely that near
        from = &e;
        return each_pair(e, [&](Pair pair) { return take_pair(pair, small); }) && test_if_enough(batch, take);
    });
    from = nullptr;
    if (result.near || !test_waiting(take)) return result;
    return {false, std::max(std::min(lower * (1 - 0x1p-18), least_gap(frame)), clearance), {}};
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
Comparison<typename Leaves::Pair> BoxWalk<A, B, Leaves>::compare(A& a, B& b, const RelativePose& b_to_a, double cutoff,
                                                                 double slack, std::optional<Pair> hint)
{
    const WalkFrame frame(a, b, b_to_a);
    const double most = cutoff + slack;
    far_ = true;
    if (frame.apart > most) return {1, frame.apart, {}};
    double lower = infinity, upper = infinity;
    std::optional<Pair> witness;
    const auto at_most = [&](double distance) {
        upper = std::min(upper, distance + frame.leaf_rounding);
        return upper + slack <= cutoff;
    };
    const auto take_pair = [&](Pair pair) {
        witness = pair;
        if (at_most(leaves_.most(pair))) return false;
        const double distance = leaves_.distance(pair);
        if (at_most(distance)) return false;
        if (leaves_.meet(pair)) return upper = 0, false;
        lower = std::min(lower, distance - frame.leaf_rounding);
        return true;
    };
    if (hint && holds(a, hint->a) && holds(b, hint->b)) {
        leaves_.start(a, b, b_to_a);
        if (!take_pair(*hint)) return ++hints_held, Comparison<Pair>{-1, upper, witness};
        lower = upper = infinity; // the result depends on the traversal alone
    }
    start_near(a, b, b_to_a, frame, most);
    bool go_on = true;
    walk(frame.gap_within(most), [&](Entry e) { return go_on = each_pair(e, take_pair); });
    if (!go_on) return {-1, upper, witness};
    lower = std::min(lower, least_box_gap(frame));
    if (lower > most) return {1, lower, {}};
    return {0, std::max(upper, most), {}};
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
DistanceBounds<typename Leaves::Pair> BoxWalk<A, B, Leaves>::distance(A& a, B& b, const RelativePose& b_to_a,
                                                                      double tolerance, double farthest)
{
    const WalkFrame frame(a, b, b_to_a);
    if (frame.apart > farthest) return {frame.apart, infinity, {}};
    origin_ = frame.origin;
    start(a, b, b_to_a, frame);
    DistanceBounds<Pair> best{infinity, infinity, {}};
    // A meeting is found early, where boxes overlap most.
    const std::uint64_t rows_before = box_rows;
    std::size_t batch = first_batch;
    const auto take_meeting = [&](Pair pair) {
        best = {0, 0, pair};
        return false;
    };
    walk(frame.gap_within(0), [&](Entry e) {
        wait(e, [](const Pair&) { return false; });
        return test_if_enough(batch, take_meeting);
    });
    if (best.nearest || !leaves_.meeting(std::span<const Pair>(waiting_), take_meeting)) return best;
    // Projections onto the line through the nearest points show nearly the distance of all primitives near them. The
    // neighbours of the last pair show it on the line of that pair.
    take_line(Line(b_to_a(b.centre()) - a.centre(), b_to_a));
    Line last_line = line_;
    double share = 1; // search for pairs nearer than this share of the distance of the nearest pair
    double most;      // primitives farther apart do not matter
    float cutoff;     // boxes with a larger gap do not matter
    const auto narrow_down = [&] {
        const double nearer = std::min(share * best.upper, best.upper - tolerance);
        cutoff = std::min(frame.gap_within(std::min(nearer, farthest)), 0x1p90f);
        // Pairs that share the nearest points with the nearest pair are equally near except for rounding.
        most = std::min(nearer - 3 * frame.leaf_rounding, farthest);
    };
    const auto measure = [&] {
        measure_waiting(frame, [&](const Pair& pair, const Nearest& points) {
            last_line = Line(points.between, b_to_a);
            best.lower = std::min(best.lower, points.lower);
            if (points.upper >= best.upper || points.lower > farthest) return;
            best.upper = points.upper, best.nearest = pair;
            take_line(last_line);
        });
        narrow_down();
    };
    const auto parted = [&](double apart) {
        if (apart <= most) return false;
        best.lower = std::min(best.lower, apart);
        return true;
    };
    const auto take_leaves = [&](Entry e) {
        const auto apart = [&](const auto& of_a, const auto& of_b, const Line& line) {
            return low_b(of_b, line) - high_a(of_a, line) - frame.leaf_rounding;
        };
        const auto of_a = a_.primitives(e.slot_a(), e.lane_a());
        const auto of_b = b_.primitives(e.slot_b(), e.lane_b());
        if (parted(apart(of_a, of_b, line_)) || parted(apart(of_a, of_b, last_line))) return;
        each_pair(e, [&](Pair pair) {
            const std::array one_a{pair.a};
            const std::array one_b{pair.b};
            if (!parted(apart(one_a, one_b, line_)) && !parted(apart(one_a, one_b, last_line)))
                waiting_.push_back(pair);
            return true;
        });
        if (waiting_.size() >= (best.nearest ? measured : 1)) measure();
    };
    // Depth first: a heap of all boxes would open half as many, but maintaining it costs more than opening them.
    const auto look = [&](double share_of_nearest) {
        share = share_of_nearest, best.lower = infinity;
        start_again(), narrow_down();
        while (top_) {
            const Entry e = stack_[--top_];
            if (e.gap > cutoff)
                best.lower = std::min(best.lower, frame.at_least(e.gap));
            else if (!both_leaves(e))
                sort_last(open<true>(e, cutoff));
            else
                take_leaves(e);
        }
        measure();
    };
    // Pairs in overlapping boxes that did not meet are near. If there are none, a coarse search finds the line early.
    // Its share is larger for geometries that are far apart: few of their pairs are nearer than that.
    if (waiting_.size() > most_seeds) waiting_.resize(most_seeds);
    measure();
    if (!best.nearest) look(box_rows - rows_before > 8 ? 0.5 : 0.85);
    if (best.nearest) look(1); // otherwise the distance is above the cutoff `farthest`
    best.lower = std::max(std::min(best.lower, least_box_gap(frame)), 0.0);
    return best;
}

} // namespace oncollide
