// What a geometry gives to take part in the walk over boxes (box_walk.hpp). A new kind of geometry is a node opener, a
// class that is a BoxHierarchy, and tests of its primitives against those of others, classes that are LeafTests;
// nothing else. Both are template parameters of the walk: no call through a pointer for each node.
#pragma once
#include <concepts>
#include <cstdint>
#include <ranges>
#include <span>

#include <Eigen/Core>

#include <oncollide/narrowphase/obb/box_node.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>

namespace oncollide {

/// Of the boxes of an open node, a bit each.
struct LaneMasks {
    std::uint32_t leaves;  ///< of few primitives, which are tested once the other side has come to a leaf too
    std::uint32_t singles; ///< of one primitive, without parts. Other leaves have parts: they are opened where what
                           ///< they are compared with is smaller
};

/// A geometry as nodes of up to eight oriented boxes, in its own frame relative to centre(), and primitives in them:
/// triangles, cells, shapes. The nodes form a tree, that may be stored, grown while it is read, or computed.
///
/// - `Node` names a node, `Primitive` a primitive; both are small values. `root` is a node that holds one box around
/// all.
/// - `centre()` and `radius()`: a ball around the primitives, in the geometry's frame, metres. What the walk allows for
///   rounding comes from it.
/// - `open(node, placement, boxes)` gives the node's boxes relative to the centre, moved by the placement unless that
///   is null, and their margin. Each holds all of its primitives, off by no more than WalkFrame counts: what is far
///   from `from` of the placement may be off by more. Lanes past the last box have centres at 1e30.
/// - `child(node, k)` names the node of the parts of box k, which is no single.
/// - `primitives(node, k)` is a range of the primitives in box k, which must be a leaf.
/// - optional, `starts(box, size, nodes)` of a large geometry: where to start for what is in a box (MapTree::starts).
/// Many walks read a hierarchy side by side.
template <class H>
concept BoxHierarchy = requires(H& h, const H& same, typename H::Node node, unsigned k, const BoxPlacement* placement,
                                OpenBoxes& boxes)
{
    typename H::Primitive;
    {
        H::root
        } -> std::convertible_to<typename H::Node>;
    {
        same.centre()
        } -> std::convertible_to<Eigen::Vector3d>;
    {
        same.radius()
        } -> std::convertible_to<double>;
    {
        same.open(node, placement, boxes)
        } -> std::same_as<LaneMasks>;
    {
        h.child(node, k)
        } -> std::same_as<typename H::Node>;
    {
        same.primitives(node, k)
        } -> std::ranges::forward_range;
    requires std::convertible_to < std::ranges::range_value_t<decltype(same.primitives(node, k))>,
    typename H::Primitive > ;
};

/// Tests of primitives of A against primitives of B, exact for their coordinates as B's are placed by the relative
/// pose. One thread's working memory, started for each query.
///
/// - `Pair` is an aggregate {a, b} of two primitives.
/// - `start(a, b, b_to_a)` begins a query; it may keep references to all three.
/// - `meeting(pairs, found)` calls found(pair) for those that meet, touching included, while it returns true, and
///   returns whether it always did. Given many pairs at a time; eight fit the kernels.
/// - `least_gap(rounding)`: at least so far apart are the pairs that meeting() saw and did not find, since start(); > 0
///   where doubles can express it. Distances by `distance` err by at most `rounding`.
/// - `meet(pair)`, exactly; `distance(pair)` of a pair that does not meet; `most(pair)`, a cheap upper bound on it;
///   `nearest(pair)`: the nearest points, or, where rounding may put the distance farther off, `bounds(pair)` as
///   ConvexDistance has them.
/// - `high_a(primitive, line)`, `low_b(primitive, line)`: the most and the least that points of theirs show along a
///   line, each in its own geometry's frame. Cheap: they bound distances.
/// - optional, `nearest(pairs, take)`: take(pair, points) for each of them, for less than `nearest(pair)` takes.
template <class L, class A, class B>
concept LeafTests = requires(L& tests, A& a, B& b, const RelativePose& b_to_a, typename L::Pair pair,
                             std::span<const typename L::Pair> pairs, double rounding)
{
    typename L::Pair;
    {typename L::Pair{typename A::Primitive{}, typename B::Primitive{}}};
    tests.start(a, b, b_to_a);
    {
        tests.meeting(pairs, [](typename L::Pair) { return true; })
        } -> std::same_as<bool>;
    {
        tests.least_gap(rounding)
        } -> std::same_as<double>;
    {
        tests.meet(pair)
        } -> std::same_as<bool>;
    {
        tests.distance(pair)
        } -> std::same_as<double>;
    {
        tests.most(pair)
        } -> std::same_as<double>;
    {
        tests.high_a(pair.a, Eigen::Vector3d())
        } -> std::same_as<double>;
    {
        tests.low_b(pair.b, Eigen::Vector3d())
        } -> std::same_as<double>;
    {
        tests.nearest(pair)
        } -> std::same_as<NearestPoints>;
};

} // namespace oncollide
