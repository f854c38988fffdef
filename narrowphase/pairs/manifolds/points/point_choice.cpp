#include <oncollide/narrowphase/pairs/manifolds/points/point_choice.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

namespace oncollide {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

auto key_of(const ManifoldCandidate& c)
{
    return std::tuple(c.a, c.b, c.of, c.at.x(), c.at.y(), c.at.z());
}

double turn(const Vector2d& u, const Vector2d& v)
{
    return u.x() * v.y() - u.y() * v.x();
}

} // namespace

/// Keeps the candidate of the largest value above `least`; of nearly equal ones the deepest, then the first by its key,
/// so that ties do not depend on the order of the candidates.
void PointChoice::take(auto value, double least, double tie)
{
    const std::vector<ManifoldCandidate>& all = *all_;
    double most = -unbounded, deepest = -unbounded;
    for (std::size_t i = 0; i < all.size(); ++i) most = std::max(most, values_[i] = value(i));
    if (!(most > least) && !kept_.empty()) return;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (values_[i] >= most - tie) deepest = std::max(deepest, all[i].depth);
    auto best = static_cast<std::uint32_t>(all.size());
    for (std::uint32_t i = 0; i < all.size(); ++i)
        if (values_[i] >= most - tie && all[i].depth >= deepest - manifold_limits::same_depth_share * size_ &&
            (best == all.size() || key_of(all[i]) < key_of(all[best])))
            best = i;
    kept_.push_back(best);
}

/// The edges of the polygon around the kept points, as their lengths times the outward normals.
void PointChoice::find_edges()
{
    edges_.clear();
    for (const std::uint32_t u : kept_)
        for (const std::uint32_t v : kept_) {
            if (u == v) continue;
            const Vector2d way = flat_[v] - flat_[u], out(way.y(), -way.x());
            const auto inside = [&](std::uint32_t w) { return w == u || w == v || out.dot(flat_[w] - flat_[u]) <= 0; };
            if (std::ranges::all_of(kept_, inside)) edges_.emplace_back(flat_[u], out);
        }
}

const std::vector<std::uint32_t>& PointChoice::choose(const std::vector<ManifoldCandidate>& all, const Vector3d& normal,
                                                      std::size_t most)
{
    all_ = &all, flat_.clear(), kept_.clear(), values_.resize(all.size());
    const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    Vector2d low(unbounded, unbounded), high = -low, middle(0, 0);
    double deepest = -unbounded;
    for (const ManifoldCandidate& c : all) {
        flat_.emplace_back(u.dot(c.at), v.dot(c.at));
        low = low.cwiseMin(flat_.back()), high = high.cwiseMax(flat_.back()), middle += flat_.back();
        deepest = std::max(deepest, c.depth);
    }
    size_ = (high - low).norm(), middle /= double(all.size());
    const double same = manifold_limits::same_share * size_;
    const auto outermost = [&](std::size_t i) { // compares the deepest candidates
        return all[i].depth >= deepest - same ? (flat_[i] - middle).norm() : -1;
    };
    take(outermost, -unbounded, same);
    if (most > 1) // the farthest
        take([&](std::size_t i) { return (flat_[i] - flat_[kept_[0]]).norm(); }, same, same);
    if (most > 2 && kept_.size() == 2) { // the largest triangle
        const Vector2d from = flat_[kept_[0]], way = flat_[kept_[1]] - from;
        const double least = same * way.norm();
        take([&](std::size_t i) { return std::abs(turn(way, flat_[i] - from)); }, least, least);
    }
    while (kept_.size() > 2 && kept_.size() < most) { // the most area added outside an edge
        const std::size_t before = kept_.size();
        find_edges();
        const auto outside = [&](std::size_t i) {
            double area = 0;
            for (const auto& [from, out] : edges_) area = std::max(area, out.dot(flat_[i] - from));
            return area;
        };
        take(outside, same * size_, same * size_);
        if (kept_.size() == before) break;
    }
    return kept_;
}

} // namespace oncollide
