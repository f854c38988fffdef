// Traversal of two hierarchies of oriented boxes: the larger box is opened, and of its parts the one
// that most likely holds a meeting is followed first. All queries on boxes are built from these steps. Code that
// instantiates it, or calls a query with a visitor, includes the header that defines the query: box_walk_queries.hpp,
// box_walk_distance.hpp, box_walk_entry.hpp or box_walk_all.hpp.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>
#include <oncollide/narrowphase/walks/open_nodes.hpp>
#include <oncollide/narrowphase/walks/walk_frame.hpp>
#include <oncollide/narrowphase/walks/walk_results.hpp>

namespace oncollide {

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

    /// Calls visit(pair) once for each pair of primitives that may be at most `clearance` apart, in any order. Defined
    /// in box_walk_all.hpp.
    void all_near(A& a, B& b, const RelativePose& b_to_a, double clearance, auto visit);

    /// Decides whether the distance is at most `clearance`. Geometries farther apart than the clearance, but at most
    /// clearance + tolerance apart, may be reported as near. Whether they are does not depend on `hint`.
    NearBounds<Pair> near(A& a, B& b, const RelativePose& b_to_a, double clearance, double tolerance,
                          std::optional<Pair> hint, std::optional<Place>* place = nullptr);

    /// Decides whether the distance, in A's frame, is at most `cutoff`. A hint is two primitives that were that near.
    /// @param slack  error bound of the caller's cutoff, besides rounding
    Comparison<Pair> compare(A& a, B& b, const RelativePose& b_to_a, double cutoff, double slack,
                             std::optional<Pair> hint);

    /// Bounds of the distance, at most `tolerance` plus rounding apart. Depth first, the nearest boxes first. Beyond
    /// the cutoff: lower > cutoff, upper = inf. Otherwise both are finite.
    DistanceBounds<Pair> distance(A& a, B& b, const RelativePose& b_to_a, double tolerance, double cutoff);

    /// A lower bound of the time at which primitives first meet during a motion. Cost: proportional to the number of
    /// boxes that may meet before that time.
    FirstEntry<Pair> first_entry(A& a, B& b, const RelativePose& b_to_a, const SweptMotion& motion);

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
        float gap = 0;           ///< the gap; with Gaps::likely, the order instead

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
        leaves.nearest(pairs, 0.0, [](const Pair&, const NearestPoints&) {});
    };
    static constexpr std::size_t measured = measures_many ? 4 : 1, most_seeds = 2 * measured;
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
        std::fill(std::begin(nearest_), std::end(nearest_), float_infinity);
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
    /// As start(), for primitives within `cutoff`; in a large geometry it starts only around the other geometry.
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
            for (const typename A::Node& node : starts_) compare<Gaps::near>({}, true, a_.open(node), far);
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
        // Up to a hundred triangles: a pair mostly meets there again, for a quarter of the cost of a traversal.
        constexpr int levels = 2;
        if (!place) return;
        for (std::size_t i = 0; i < from_.size(); ++i)
            if (waiting_[i].a == pair.a && waiting_[i].b == pair.b) from = &from_[i];
        if (!from) return; // the pair is the hint
        const auto [slot_a, lane_a] = a_.up(from->slot_a(), from->lane_a(), levels);
        const auto [slot_b, lane_b] = b_.up(from->slot_b(), from->lane_b(), levels);
        place->emplace(a, a_[slot_a].node, lane_a, b, b_[slot_b].node, lane_b);
    }
    bool both_leaves(Entry e) const { return a_[e.slot_a()].leaf(e.lane_a()) && b_[e.slot_b()].leaf(e.lane_b()); }
    /// True if the box of A is opened next: the larger box is opened, unless it is single.
    bool opens_a(Entry e) const
    {
        return b_[e.slot_b()].single(e.lane_b()) ||
               (!a_[e.slot_a()].single(e.lane_a()) &&
                a_[e.slot_a()].size(e.lane_a()) >= b_[e.slot_b()].size(e.lane_b()));
    }
    bool each_pair(Entry e, auto visit) const;
    enum class Gaps : std::uint8_t { near, likely, far, in_time }; ///< the kernel's functions
    template <Gaps gaps>
    unsigned open(Entry e, float gap_limit);
    template <Gaps gaps>
    unsigned compare(Entry e, bool down_a, std::uint32_t slot, float gap_limit);
    void set_motion(BoxMotion& motion, Entry e, bool down_a) const;
    SweptParts motion_of(Entry e) const;
    double high_a(const auto& of_a, const WalkLine& line) const
    {
        double high = -infinity;
        for (const auto a : of_a) high = std::max(high, leaves_.high_a(a, line.in_a));
        return high;
    }
    double low_b(const auto& of_b, const WalkLine& line) const
    {
        double low = infinity;
        for (const auto b : of_b) low = std::min(low, leaves_.low_b(b, line.in_b));
        return low + line.shift;
    }
    /// Sets the direction onto which boxes are also projected.
    void take_line(const WalkLine& line)
    {
        ++line_number_;
        line_ = line, origin_along_line_ = line.in_a.dot(origin_);
        for (int i = 0; i < 3; ++i) toward_b_[i] = static_cast<float>(box_line_length * line.in_a[i]);
    }
    struct Reaches {
        std::uint32_t line[8] = {}; ///< by box: the number of the line that its reach is for
        double reach[8];
    };
    /// Upper bound of the projection of a box's contents onto a direction, relative to the origin. For a leaf it bounds
    /// the primitives; in a mesh with many triangles it bounds the boxes in the child node, which follow the contents
    /// better than the box does. Opens the node. Bounds are kept until the line changes, because each box is compared
    /// with many others.
    double reach_of(auto& nodes, std::vector<Reaches>& kept, std::uint32_t slot, unsigned k,
                    const float (&direction)[3], auto of_leaf)
    {
        if (kept.size() <= slot) kept.resize(2 * std::size_t(slot) + 16);
        if (kept[slot].line[k] == line_number_) return kept[slot].reach[k];
        double reach;
        if (nodes[slot].leaf(k) || !nodes.has_many()) {
            const OpenBoxes& boxes = nodes[slot].boxes;
            reach = nodes[slot].leaf(k) ? box_line_length * of_leaf() : reach_of_box(boxes, k, direction);
            reach += boxes.margin;
        } else {
            const OpenBoxes& boxes = nodes[nodes.descend(slot, k)].boxes;
            reach = double(kernel_.reach(boxes, direction)) + boxes.margin;
        }
        kept[slot].line[k] = line_number_;
        return kept[slot].reach[k] = reach;
    }
    static float reach_of_box(const OpenBoxes& boxes, unsigned k, const float (&direction)[3])
    {
        const auto along = [&](const auto& v) {
            return direction[0] * v[0][k] + direction[1] * v[1][k] + direction[2] * v[2][k];
        };
        float reach = along(boxes.c);
        for (int i = 0; i < 3; ++i) reach += boxes.h[i][k] * std::abs(along(boxes.axis[i]));
        return reach;
    }
    double reach_of_a(Entry e)
    {
        return reach_of(a_, reaches_a_, e.slot_a(), e.lane_a(), toward_b_,
                        [&] { return high_a(a_.primitives(e.slot_a(), e.lane_a()), line_) - origin_along_line_; });
    }
    double reach_of_b(Entry e)
    {
        const float toward_a[3] = {-toward_b_[0], -toward_b_[1], -toward_b_[2]};
        return reach_of(b_, reaches_b_, e.slot_b(), e.lane_b(), toward_a,
                        [&] { return origin_along_line_ - low_b(b_.primitives(e.slot_b(), e.lane_b()), line_); });
    }
    /// The gap along the line between the contents of two boxes.
    float line_gap(Entry e) { return static_cast<float>(-reach_of_a(e) - reach_of_b(e)); }
    /// The direction from the other box towards the parts of this one, and the reach of the other box.
    BoxLine line_to(Entry e, bool down_a)
    {
        BoxLine line;
        for (int i = 0; i < 3; ++i) line.direction[i] = down_a ? -toward_b_[i] : toward_b_[i];
        line.other_reach = static_cast<float>(down_a ? reach_of_b(e) : reach_of_a(e));
        return line;
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
    template <Gaps gaps = Gaps::likely>
    void walk(float gap_limit, auto take_leaves, auto ends);
    template <Gaps gaps = Gaps::likely>
    void walk(float gap_limit, auto take_leaves)
    {
        walk<gaps>(gap_limit, take_leaves, [](Entry) { return false; });
    }
    void walk_all(float gap_limit, auto take_leaves);
    bool test_waiting(auto found)
    {
        const bool go_on = leaves_.meeting(std::span<const Pair>(waiting_), found);
        waiting_.clear(), from_.clear();
        return go_on;
    }
    bool test_if_enough(std::size_t& batch, auto found);
    /// Bounds of the distance of primitives that do not meet, and the nearest points.
    struct Nearest {
        double lower, upper;
        Eigen::Vector3d a, b;
    };
    Nearest nearest(const Pair& pair, const WalkFrame& frame)
    {
        if constexpr (requires { leaves_.bounds(pair); }) {
            const auto found = leaves_.bounds(pair);
            return {found.lower, found.upper, found.on_a, found.on_b};
        } else {
            const NearestPoints found = leaves_.nearest(pair, 0.5 * frame.leaf_rounding);
            return {found.distance - frame.leaf_rounding, found.distance + frame.leaf_rounding, found.a, found.b};
        }
    }
    /// Calls take(pair, points) for all waiting pairs.
    void measure_waiting(const WalkFrame& frame, auto take)
    {
        if constexpr (measures_many) {
            const double rounding = frame.leaf_rounding;
            leaves_.nearest(
                std::span<const Pair>(waiting_), 0.5 * rounding, [&](const Pair& pair, const NearestPoints& found) {
                    take(pair, Nearest{found.distance - rounding, found.distance + rounding, found.a, found.b});
                });
        } else {
            for (const Pair& pair : waiting_) take(pair, nearest(pair, frame));
        }
        waiting_.clear();
    }
    double least_box_gap(const WalkFrame& frame) const { return frame.at_least(*std::ranges::min_element(nearest_)); }
    /// Lower bound of the distance if no two primitives met, from the rejected boxes and the tested primitives.
    double least_gap(const WalkFrame& frame)
    {
        return std::min(least_box_gap(frame) * (1 - 0x1p-18),
                        frame.placed_at_least(leaves_.least_gap(frame.leaf_rounding)));
    }

    const OrientedBoxKernel kernel_ = oriented_box_kernel();
    OpenNodes<A> a_;
    OpenNodes<B> b_;
    std::vector<Entry> stack_; ///< the first top_ entries are in use
    std::size_t top_ = 0;
    bool far_ = true;
    std::vector<typename A::Node> starts_;
    std::vector<Pair> waiting_;                  ///< pairs to be tested together
    std::vector<Entry> from_;                    ///< the boxes that contain them
    alignas(32) float nearest_[8];               ///< least gaps of the rejected boxes
    Eigen::Vector3d origin_;                     ///< origin of the boxes' coordinates, in A's frame
    WalkLine line_;                              ///< the line from A's nearest point found so far to B's
    std::uint32_t line_number_ = 0;              ///< number of the current line, counted over all lines so far
    std::vector<Reaches> reaches_a_, reaches_b_; ///< by slot
    double origin_along_line_;
    SweptMotion swept_;              ///< motion of points in the boxes' coordinates
    double turn_a_ = 0, turn_b_ = 0; ///< lengths of the rotations
    double box_rounding_ = 0;
    float toward_b_[3]; ///< line_ for boxes: a little shorter, so that rounding makes it no longer than 1
    Leaves leaves_;
};

} // namespace oncollide
