// The interface of a geometry to the traversal of boxes (box_walk.hpp). A new kind of geometry needs a class that opens
// nodes (BoxHierarchy), and classes that test its primitives against other primitives (LeafTests); nothing else. Both
// are template parameters of the traversal, which avoids an indirect call per node.
#pragma once
#include <concepts>
#include <cstdint>
#include <ranges>
#include <span>

#include <Eigen/Core>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/obb/box_node.hpp>

namespace oncollide {

/// One bit for each box of an open node.
struct LaneMasks {
    std::uint32_t leaves;  ///< boxes of few primitives, which are tested once the other side is at a leaf too
    std::uint32_t singles; ///< boxes of one primitive, without a child node. Other leaves have one: they are opened if
                           ///< the box that they are compared with is smaller
};

/// A geometry as nodes of up to eight oriented boxes, in its own frame relative to centre(), with primitives in them:
/// triangles, cells, shapes. The nodes form a tree, which may be stored, grown during traversals, or computed.
///
/// - `Node` names a node, `Primitive` a primitive; both are small values. `root` is a node that holds one box around
///   all primitives.
/// - `centre()` and `radius()`: a sphere around the primitives, in the geometry's frame, metres. The traversal derives
///   its rounding allowance from it.
/// - `open(node, placement, boxes)` writes the node's boxes, relative to the centre and moved by the placement unless
///   it is null, and their margin. Each box encloses all of its primitives, with an error that WalkFrame allows for;
///   far from the placement's `from` the error may be larger. Lanes past the last box have centres at 1e30.
/// - `child(node, k)` names the child node of box k, which must not be a single.
/// - `primitives(node, k)` is a range of the primitives in box k, which must be a leaf.
/// - optional, `starts(box, size, nodes)` of a large geometry: where to start for the primitives in a box
///   (MapTree::starts).
/// Many traversals may read a hierarchy concurrently.
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

/// Tests of primitives of A against primitives of B, exact for B's coordinates as moved by the relative pose. One
/// thread's working memory, started for each query.
///
/// - `Pair` is an aggregate {a, b} of two primitives.
/// - `start(a, b, b_to_a)` begins a query; it may keep references to all three.
/// - `meeting(pairs, found)` calls found(pair) for pairs that meet, touching included, while it returns true, and
///   returns whether it always did. Callers pass many pairs at a time; eight fit the kernels.
/// - `least_gap(rounding)`: a lower bound of the distance of the pairs that meeting() has tested since start() and that
///   do not meet; > 0 where doubles can express it. `rounding` is at least twice the error of a corner
///   as placed.
/// - `meet(pair)` decides exactly. `nearest(pair, rounding)` returns the nearest points of a pair that does not meet:
/// its
///   distance is certainly within `rounding` of the one returned; tests that cannot promise this have `bounds(pair)`
///   instead, as ConvexDistance returns them. `most(pair)` is a cheap upper bound of the distance.
/// - `high_a(primitive, line)`, `low_b(primitive, line)`: the largest and the smallest projection of the primitive onto
///   a direction in its own geometry's frame. Cheap: they bound distances.
/// - optional, `from_a(primitive, point)`, `from_b`: the squared distance of a primitive from a point of A's frame, for
///   a first guess of the distance.
/// - optional, `nearest(pairs, rounding, take)`: calls take(pair, points) for each pair, and costs less than
///   `nearest(pair, rounding)` for each.
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
        tests.most(pair)
        } -> std::same_as<double>;
    {
        tests.high_a(pair.a, Eigen::Vector3d())
        } -> std::same_as<double>;
    {
        tests.low_b(pair.b, Eigen::Vector3d())
        } -> std::same_as<double>;
    {
        tests.nearest(pair, rounding)
        } -> std::same_as<NearestPoints>;
};

} // namespace oncollide
