#include "trees/surface_index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t leaf_size = 4;

double squared_distance(const Vector3d& p, const Aabb& box)
{
    return (box.min - p).cwiseMax(p - box.max).cwiseMax(0.0).squaredNorm();
}

Vector3d nearest_point(const Vector3d& from, const Vector3d& a, const Vector3d& b)
{
    const Vector3d along = b - a;
    const double length2 = along.squaredNorm();
    return length2 > 0 ? Vector3d(a + std::clamp((from - a).dot(along) / length2, 0.0, 1.0) * along) : a;
}

} // namespace

Vector3d nearest_point(const Vector3d& from, const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    const Vector3d n = (b - a).cross(c - a);
    const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    const auto left = [&](const Vector3d& p, const Vector3d& q) { return n.dot((q - p).cross(from - p)) > 0; };
    const bool thin = n.norm() < 1e-7 * longest2; // rounding dominates its normal; its edges are accurate enough
    if (!thin && left(a, b) && left(b, c) && left(c, a)) return from - n.dot(from - a) / n.squaredNorm() * n;
    Vector3d best = nearest_point(from, a, b);
    for (const Vector3d& p : {nearest_point(from, b, c), nearest_point(from, c, a)})
        if ((p - from).squaredNorm() < (best - from).squaredNorm()) best = p;
    return best;
}

SurfaceIndex::SurfaceIndex(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles.size())
{
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.push_back({{}, 0, static_cast<std::uint32_t>(order_.size()), 0});
    split(0);
}

void SurfaceIndex::split(std::uint32_t node)
{
    const auto middle_of = [&](std::uint32_t t, int axis) {
        double sum = 0;
        for (const std::uint32_t v : mesh_.triangles[t]) sum += mesh_.vertices[v][axis];
        return sum;
    };
    Aabb box;
    const std::uint32_t begin = nodes_[node].begin, end = nodes_[node].end, middle = begin + (end - begin) / 2;
    for (std::uint32_t i = begin; i < end; ++i)
        for (const std::uint32_t v : mesh_.triangles[order_[i]]) box.add(mesh_.vertices[v]);
    nodes_[node].box = box;
    if (end - begin <= leaf_size) return;
    int axis = 0;
    (box.max - box.min).maxCoeff(&axis);
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t s, std::uint32_t t) { return middle_of(s, axis) < middle_of(t, axis); });
    nodes_.push_back({{}, begin, middle, 0});
    split(static_cast<std::uint32_t>(nodes_.size() - 1));
    nodes_[node].right = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{}, middle, end, 0});
    split(nodes_[node].right);
}

SurfaceIndex::Nearest SurfaceIndex::nearest(const Vector3d& from, double enough) const
{
    Nearest best;
    double best2 = std::numeric_limits<double>::infinity();
    std::uint32_t stack[64], top = 0; // a tree of halves has at most as many levels as the index has bits
    stack[top++] = 0;
    while (top > 0 && best2 >= enough * enough) {
        const std::uint32_t at = stack[--top];
        const Node& node = nodes_[at];
        if (squared_distance(from, node.box) >= best2) continue;
        if (node.right) {
            const bool left_first =
                squared_distance(from, nodes_[at + 1].box) < squared_distance(from, nodes_[node.right].box);
            stack[top++] = left_first ? node.right : at + 1;
            stack[top++] = left_first ? at + 1 : node.right;
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            const Triangle& t = mesh_.triangles[order_[i]];
            const Vector3d p = nearest_point(from, mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]);
            if (const double d2 = (p - from).squaredNorm(); d2 < best2) best2 = d2, best.point = p;
        }
    }
    best.distance = std::sqrt(best2);
    return best;
}

void SurfaceIndex::near(const Vector3d& from, double radius, FunctionRef<void(std::uint32_t)> visit) const
{
    std::uint32_t stack[64], top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const std::uint32_t at = stack[--top];
        const Node& node = nodes_[at];
        if (squared_distance(from, node.box) > radius * radius) continue;
        if (node.right)
            stack[top++] = at + 1, stack[top++] = node.right;
        else
            for (std::uint32_t i = node.begin; i < node.end; ++i) visit(order_[i]);
    }
}

bool SurfaceIndex::inside(const Vector3d& point) const
{
    const Vector3d direction(0.8153742, 0.4671915, 0.3420817);
    const auto meets = [&](const Aabb& box) {
        double from = 0, to = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            from = std::max(from, (box.min[axis] - point[axis]) / direction[axis]);
            to = std::min(to, (box.max[axis] - point[axis]) / direction[axis]);
        }
        return from <= to;
    };
    const auto crosses = [&](const Triangle& t) {
        const Vector3d a = mesh_.vertices[t[0]] - point, b = mesh_.vertices[t[1]] - point,
                       c = mesh_.vertices[t[2]] - point;
        const double u = direction.dot(a.cross(b)), v = direction.dot(b.cross(c)), w = direction.dot(c.cross(a));
        if (!((u >= 0 && v >= 0 && w >= 0) || (u < 0 && v < 0 && w < 0))) return false;
        const Vector3d n = (b - a).cross(c - a);
        return (n.dot(a) > 0) == (n.dot(direction) > 0);
    };
    bool odd = false;
    std::uint32_t stack[64], top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const std::uint32_t at = stack[--top];
        const Node& node = nodes_[at];
        if (!meets(node.box)) continue;
        if (node.right)
            stack[top++] = at + 1, stack[top++] = node.right;
        else
            for (std::uint32_t i = node.begin; i < node.end; ++i) odd ^= crosses(mesh_.triangles[order_[i]]);
    }
    return odd;
}

} // namespace oncollide::tools
