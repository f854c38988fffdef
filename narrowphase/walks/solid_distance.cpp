#include <oncollide/narrowphase/walks/solid_distance.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/walks/walk_frame.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

const SolidGapKernel& solid_gap_kernel()
{
    static const SolidGapKernel kernel = ONCOLLIDE_CHOOSE(solid_gap_kernel);
    return kernel;
}

void set(float (&to)[3], const Vector3d& from)
{
    for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

SolidReach reach_of(const ShapeTree& shape, const Vector3d& centre, const Eigen::Matrix3d& tree_to_shape)
{
    SolidReach reach{};
    set(reach.centre, centre);
    for (int i = 0; i < 3; ++i) set(reach.axis[i], tree_to_shape.row(i));
    const Convex& solid = shape.shape();
    reach.radius = static_cast<float>(solid.radius);
    switch (solid.core) {
    case Convex::Core::ellipsoid:
        set(reach.disc, solid.high);
        break;
    case Convex::Core::cylinder:
    case Convex::Core::cone: // the cylinder around the cone
        set(reach.disc, {solid.high.x(), solid.high.x(), 0});
        set(reach.half, {0, 0, solid.high.z()});
        break;
    case Convex::Core::box:
    case Convex::Core::points:
        set(reach.half, shape.half() - Vector3d::Constant(solid.radius));
        break;
    }
    return reach;
}

} // namespace

template <class Tree>
class SolidDistance<Tree>::Query {
public:
    Query(SolidDistance& memory, const ShapeTree& shape, Tree& tree, const RelativePose& tree_to_shape, double slack)
        : memory_(memory), shape_(shape), tree_(tree), into_(tree_to_shape), slack_(slack),
          frame_(shape, tree, tree_to_shape, infinity), rounding_(frame_.box_rounding + 0x1p-17 * shape.radius()),
          above_centre_((shape.centre() - shape.shape().centre).norm() - shape.shape().inner - shape.shape().radius)
    {
        const Vector3d centre = into_.rotation.transpose() * (shape.centre() - into_.translation) - tree.centre();
        const Vector3d from = shape.radius() < tree.radius() ? centre : Vector3d::Zero();
        set(place_.from, from);
        place_.rotated = false;
        from_ = Eigen::Map<const Eigen::Vector3f>(place_.from).cast<double>();
        rest_ = centre - from_, from_ += tree.centre();
        reach_ = reach_of(shape, rest_, into_.rotation);
        set_line(Vector3d::Zero());
        corners_.start(tree);
    }

    DistanceBounds<Pair> find(double tolerance, double cutoff)
    {
        if (frame_.apart > cutoff) return {frame_.apart, infinity, {}};
        std::fill(std::begin(nearest_), std::end(nearest_), float_infinity);
        heap().clear();
        most_ = cutoff;
        dive(cutoff);
        while (!heap().empty() && best_.upper > 0) {
            std::pop_heap(heap().begin(), heap().end(), farther);
            const Entry e = heap().back();
            heap().pop_back();
            most_ = std::min({most_, best_.upper - tolerance, cutoff});
            if (at_least(e.gap) > most_) {
                best_.lower = std::min(best_.lower, at_least(e.gap));
                break; // no other entry is nearer
            }
            down(e, cutoff);
        }
        if (best_.upper == 0) return {0, 0, best_.nearest};
        for (const float gap : nearest_) best_.lower = std::min(best_.lower, at_least(gap));
        best_.lower = std::clamp(best_.lower, 0.0, best_.upper);
        return best_;
    }

private:
    static constexpr auto farther = [](const Entry& x, const Entry& y) { return x.gap > y.gap; };
    double at_least(double gap) const { return (gap - rounding_) * (1 - 0x1p-17); }
    float gap_within(double distance) const
    {
        return std::min(static_cast<float>((distance + rounding_) * (1 + 0x1p-16)), 0x1p90f);
    }
    std::vector<Entry>& heap() { return memory_.heap_; }

    /// Descends greedily to a near triangle, so that farther boxes need not be kept.
    void dive(double cutoff)
    {
        open(Tree::root, gap_within(cutoff));
        for (std::size_t from = 0; from < heap().size();) {
            const auto nearest = std::min_element(heap().begin() + std::ptrdiff_t(from), heap().end(),
                                                  [](const Entry& x, const Entry& y) { return x.gap < y.gap; });
            const Entry e = *nearest;
            *nearest = heap().back();
            heap().pop_back();
            from = heap().size();
            down(e, cutoff);
            if (is_leaf(e)) break;
        }
        std::erase_if(heap(), [&, gap_limit = gap_within(most_)](const Entry& e) {
            if (e.gap <= gap_limit) return false;
            nearest_[0] = std::min(nearest_[0], e.gap);
            return true;
        });
        std::make_heap(heap().begin(), heap().end(), farther);
        in_order_ = true;
    }
    void down(const Entry& e, double cutoff)
    {
        if (is_leaf(e)) {
            for (const std::uint32_t triangle : tree_.primitives(e.node, e.lane & 7))
                if (!take({0, triangle}, cutoff)) return;
            return;
        }
        open(tree_.child(e.node, e.lane), gap_within(most_));
    }
    static bool is_leaf(const Entry& e) { return e.lane >= leaf_lane; }

    void open(const typename Tree::Node& node, float gap_limit)
    {
        ++memory_.nodes;
        if constexpr (std::same_as<Tree, TerrainTree>) {
            if (!node.whole) return node.level == 0 ? open_cells(node, gap_limit) : open_blocks(node, gap_limit);
        }
        OpenBoxes boxes;
        const LaneMasks masks = tree_.open(node, &place_, boxes);
        float gaps[8];
        push_lanes(node, solid_gap_kernel().of_boxes(boxes, reach_, line_, gap_limit, gaps, nearest_), masks.leaves,
                   gaps);
    }
    template <class Node> // a template, so that only the tree of a terrain needs blocks and cells
    void open_blocks(const Node& node, float gap_limit)
    {
        TerrainBlocks blocks;
        tree_.open_blocks(node, from_, blocks);
        float gaps[8];
        push_lanes(node, solid_gap_kernel().of_blocks(blocks, reach_, line_, gap_limit, gaps, nearest_), 0, gaps);
    }
    void push_lanes(const typename Tree::Node& node, unsigned near, unsigned leaves, const float (&gaps)[8])
    {
        for (; near; near &= near - 1) {
            const auto lane = static_cast<std::uint32_t>(__builtin_ctz(near));
            push({gaps[lane], lane | (leaves >> lane & 1 ? leaf_lane : 0), node});
        }
    }
    template <class Node>
    void open_cells(const Node& node, float gap_limit)
    {
        TerrainCells cells;
        tree_.open_cells(node, from_, cells);
        float gaps[2][8];
        float apart = float_infinity;
        unsigned near = solid_gap_kernel().of_cells(cells, reach_, line_, gap_limit, gaps, nearest_, apart);
        if (const double upper = std::max(apart * (1 + 0x1p-18) + above_centre_, 0.0); upper < most_)
            most_ = upper, gap_limit = gap_within(upper);
        for (; near; near &= near - 1) {

            const auto k = static_cast<unsigned>(__builtin_ctz(near));
            if (gaps[k / 8][k % 8] > gap_limit) {
                nearest_[k % 8] = std::min(nearest_[k % 8], gaps[k / 8][k % 8]);
                continue;
            }
            push({gaps[k / 8][k % 8], k / 8 | leaf_lane, tree_.child(node, k % 8)});
        }
    }
    void push(const Entry& e)
    {
        heap().push_back(e);
        if (in_order_) std::push_heap(heap().begin(), heap().end(), farther);
    }

    bool take(const Pair& pair, double cutoff)
    {
        const TrianglePoints corners = corners_.points(pair.b);
        double low = infinity;
        for (const Vector3d& p : corners) low = std::min(low, direction_.dot(into_(p)));
        if (const double apart = low - most_along_ - frame_.leaf_rounding; apart > most_) {
            best_.lower = std::min(best_.lower, apart);
            return true;
        }
        ++memory_.triangles;
        const Convex triangle = convex_of(corners);
        const ConvexPair placed(shape_.shape(), triangle, into_, slack_);
        ConvexDistance d = placed.distance({.cutoff = std::min(best_.upper, cutoff)});
        if (d.lower == 0 && d.upper > 0) {
            const ConvexMeeting m = placed.meeting();
            if (m.sign > 0) d.lower = std::min(m.bound, d.upper);
            if (m.sign < 0) d.upper = 0;
        }
        best_.lower = std::min(best_.lower, d.lower);
        if (d.upper >= best_.upper || d.lower > cutoff) return true;
        best_.upper = d.upper, best_.nearest = pair;
        const Vector3d between = d.on_b - d.on_a;
        const double length = between.norm() * (1 + 0x1p-18);
        set_line(length > 0 ? Vector3d(between / length) : Vector3d(Vector3d::Zero()));
        most_ = std::min(most_, best_.upper);
        return best_.upper > 0;
    }
    /// Also bounds gaps along a direction of the shape's frame.
    void set_line(const Vector3d& direction)
    {
        direction_ = direction;
        most_along_ = shape_.shape().most_along(direction);
        const Vector3d here = into_.rotation.transpose() * direction;
        set(line_.direction, here);
        line_.other_reach = static_cast<float>(most_along_ - direction.dot(shape_.centre()) + here.dot(rest_));
    }

    static constexpr std::uint32_t leaf_lane = 8; ///< a flag in Entry::lane
    SolidDistance& memory_;
    const ShapeTree& shape_;
    Tree& tree_;
    const RelativePose& into_;
    const double slack_;
    const WalkFrame frame_;
    const double rounding_;     ///< error bound of gaps
    const double above_centre_; ///< the solid's distance is at most this much more than the distance of its box's
                                ///< centre
    BoxPlacement place_;
    Vector3d from_; ///< origin of the boxes' coordinates, in the tree's frame
    Vector3d rest_; ///< the solid's centre in the boxes' coordinates
    SolidReach reach_;
    BoxLine line_;
    Vector3d direction_;
    double most_along_;
    TriangleCorners<Tree> corners_;
    DistanceBounds<Pair> best_{infinity, infinity, {}};
    double most_ = infinity; ///< upper bound of the distance, or the cutoff
    bool in_order_ = false;  ///< true once the entries form a heap
    alignas(32) float nearest_[8];
};

template <class Tree>
DistanceBounds<typename SolidDistance<Tree>::Pair>
SolidDistance<Tree>::distance(const ShapeTree& shape, Tree& tree, const RelativePose& tree_to_shape, double slack,
                              double tolerance, double cutoff)
{
    return Query(*this, shape, tree, tree_to_shape, slack).find(tolerance, cutoff);
}

template class SolidDistance<ObbTree>;
template class SolidDistance<TerrainTree>;

} // namespace oncollide
