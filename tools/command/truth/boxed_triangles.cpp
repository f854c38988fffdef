#include "truth/boxed_triangles.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>

namespace oncollide::tools {
namespace {

constexpr std::uint32_t leaf = 4; ///< triangles, at most

constexpr std::uint32_t middle(std::uint32_t begin, std::uint32_t end)
{
    return begin + (end - begin) / 2;
}

/// Splits at the median along the longest side of the AABB of the centres.
void halve(std::span<std::uint32_t> order, const std::vector<Eigen::Vector3d>& centres)
{
    if (order.size() <= leaf) return;
    Eigen::AlignedBox3d box;
    for (std::uint32_t i : order) box.extend(centres[i]);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::uint32_t half = middle(0, std::uint32_t(order.size()));
    std::ranges::nth_element(order, order.begin() + half, {}, [&](std::uint32_t i) { return centres[i][axis]; });
    halve(order.first(half), centres), halve(order.subspan(half), centres);
}

} // namespace

HalvedMesh::HalvedMesh(const Mesh& m) : mesh(&m), order(m.triangles.size())
{
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Eigen::Vector3d> centres;
    for (const Triangle& t : m.triangles)
        centres.push_back((m.vertices[t[0]] + m.vertices[t[1]] + m.vertices[t[2]]) / 3);
    halve(order, centres);
}

BoxedTriangles::BoxedTriangles(const HalvedMesh& halved, FunctionRef<Eigen::Vector3d(const Eigen::Vector3d&)> place)
    : halved_(&halved), points_(mesh().vertices.size()),
      boxes_(2 * std::bit_ceil((halved.order.size() + leaf - 1) / leaf)), triangle_boxes_(halved.order.size())
{
    std::ranges::transform(mesh().vertices, points_.begin(), place);
    fill(1, 0, std::uint32_t(halved.order.size()));
}

TrianglePoints BoxedTriangles::triangle(std::uint32_t i) const
{
    const Triangle& t = mesh().triangles[i];
    return {points_[t[0]], points_[t[1]], points_[t[2]]};
}

const BoxedTriangles::Box& BoxedTriangles::fill(std::uint32_t node, std::uint32_t begin, std::uint32_t end)
{
    if (end - begin > leaf) {
        const std::uint32_t half = middle(begin, end);
        return boxes_[node] = fill(2 * node, begin, half).merged(fill(2 * node + 1, half, end));
    }
    for (std::uint32_t k = begin; k < end; ++k) {
        for (std::uint32_t v : mesh().triangles[halved_->order[k]]) triangle_boxes_[k].extend(points_[v]);
        boxes_[node].extend(triangle_boxes_[k]);
    }
    return boxes_[node];
}

class NearPairs {
public:
    NearPairs(const BoxedTriangles& a, const BoxedTriangles& b, const double& cutoff,
              FunctionRef<void(std::uint32_t, std::uint32_t)> look)
        : a_(a), b_(b), cutoff_(cutoff), look_(look)
    {
        search(whole(a), whole(b), a.box().exteriorDistance(b.box()));
    }

private:
    struct Part {
        std::uint32_t node, begin, end;
        bool is_leaf() const { return end - begin <= leaf; }
        std::array<Part, 2> halves() const
        {
            return {Part{2 * node, begin, middle(begin, end)}, Part{2 * node + 1, middle(begin, end), end}};
        }
    };
    static Part whole(const BoxedTriangles& t) { return {1, 0, std::uint32_t(t.triangle_boxes_.size())}; }

    double distance(Part p, Part q) const { return a_.boxes_[p.node].exteriorDistance(b_.boxes_[q.node]); }

    void search(Part p, Part q, double apart)
    {
        if (apart > cutoff_) return;
        if (p.is_leaf() && q.is_leaf()) return compare(p, q);
        const bool of_a = q.is_leaf() || (!p.is_leaf() &&
                                          a_.boxes_[p.node].sizes().maxCoeff() >= b_.boxes_[q.node].sizes().maxCoeff());
        const std::array<Part, 2> halves = (of_a ? p : q).halves();
        const auto at = [&](Part half) { return of_a ? distance(half, q) : distance(p, half); };
        const std::array<double, 2> distances{at(halves[0]), at(halves[1])};
        const std::size_t nearer = distances[1] < distances[0];
        for (std::size_t k : {nearer, 1 - nearer})
            of_a ? search(halves[k], q, distances[k]) : search(p, halves[k], distances[k]);
    }

    void compare(Part p, Part q)
    {
        for (std::uint32_t i = p.begin; i < p.end; ++i)
            for (std::uint32_t j = q.begin; j < q.end; ++j)
                if (a_.triangle_boxes_[i].exteriorDistance(b_.triangle_boxes_[j]) <= cutoff_)
                    look_(a_.halved_->order[i], b_.halved_->order[j]);
    }

    const BoxedTriangles &a_, &b_;
    const double& cutoff_;
    FunctionRef<void(std::uint32_t, std::uint32_t)> look_;
};

void for_near_pairs(const BoxedTriangles& a, const BoxedTriangles& b, const double& cutoff,
                    FunctionRef<void(std::uint32_t i, std::uint32_t j)> look)
{
    NearPairs(a, b, cutoff, look);
}

} // namespace oncollide::tools
