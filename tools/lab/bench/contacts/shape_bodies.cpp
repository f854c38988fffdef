#include "bench/contacts/shape_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/shapes/convex_pair.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double cell_size = 0.5;

} // namespace

double way_until_touching(const Convex& a, const Isometry3d& at_a, const Convex& b, Isometry3d at_b,
                          const Vector3d& way)
{
    constexpr double touching = 1e-7, passing = 1e-6;
    double gone = 0;
    for (int k = 0; k < 100; ++k) {
        const RelativePose b_to_a(at_a, at_b);
        const ConvexDistance gap = ConvexPair(a, b, b_to_a, 0).distance({.tolerance = touching / 4});
        if (gap.upper <= touching) break;
        const double approach = (at_a.linear() * (gap.on_a - gap.on_b)).dot(way) / gap.upper;
        if (approach <= passing) return std::numeric_limits<double>::infinity();
        gone += gap.upper / approach, at_b.translation() += gap.upper / approach * way;
    }
    return gone;
}

ShapeHeap::Cell ShapeHeap::cell_of(double x, double y)
{
    return {static_cast<int>(std::floor(x / cell_size)), static_cast<int>(std::floor(y / cell_size))};
}

double ShapeHeap::lowest(Model& model, Isometry3d pose, double limit)
{
    const Vector3d down = -Vector3d::UnitZ(), at = pose.translation();
    double z = model.convex().most_along(pose.linear().transpose() * down); // on the floor
    const double wide = model.reach() + largest_;
    const Cell low = cell_of(at.x() - wide, at.y() - wide), high = cell_of(at.x() + wide, at.y() + wide);
    above_.clear();
    for (int x = low.first; x <= high.first; ++x)
        for (int y = low.second; y <= high.second; ++y) {
            const auto cell = cells_.find({x, y});
            if (cell == cells_.end()) continue;
            for (const Placed& placed : cell->second) {
                const double both = model.reach() + placed.model->reach();
                const Vector3d& other = placed.pose.translation();
                if ((other - at).head<2>().squaredNorm() < both * both) above_.push_back({other.z() + both, &placed});
            }
        }
    std::ranges::sort(above_, std::greater<>(), &Above::most);
    for (const Above& other : above_) {
        if (other.most <= z) break;
        if (z >= limit) return limit;
        pose.translation().z() = other.most;
        z = std::max(z, other.most - way_until_touching(other.placed->model->convex(), other.placed->pose,
                                                        model.convex(), pose, down));
    }
    return std::min(z, limit);
}

Isometry3d ShapeHeap::add(Model& model, const Quaterniond& rotation, double x, double y)
{
    Isometry3d pose(rotation);
    pose.translation() = Vector3d(half_ * x, half_ * y, 0);
    pose.translation().z() = lowest(model, pose, std::numeric_limits<double>::infinity());
    constexpr double finest = 2e-4;
    constexpr int directions = 8;
    double phase = 0;
    for (const double longest : {0.08, 0.02, 0.02}) // again, in other directions: it may have stopped in a furrow
        for (double stride = longest; stride >= finest; stride /= 2)
            for (bool lower = true; lower; phase += 0.4) {
                Isometry3d best = pose;
                for (int k = 0; k < directions; ++k) {
                    const double angle = phase + 2 * M_PI * k / directions;
                    Isometry3d tried = pose;
                    tried.translation() += stride * Vector3d(std::cos(angle), std::sin(angle), 0);
                    if (tried.translation().head<2>().cwiseAbs().maxCoeff() > half_) continue;
                    tried.translation().z() = lowest(model, tried, best.translation().z());
                    if (tried.translation().z() < best.translation().z()) best = tried;
                }
                lower = best.translation().z() < pose.translation().z() - 0.01 * stride;
                if (lower) pose = best;
            }
    pose.translation().z() -= sink_;
    largest_ = std::max(largest_, model.reach());
    cells_[cell_of(pose.translation().x(), pose.translation().y())].push_back({&model, pose});
    return pose;
}

Isometry3d lie_on(const Terrain& terrain, Model& model, const Eigen::Vector2d& at, double yaw, bool on_its_side,
                  double sink)
{
    const Eigen::Vector2d from(terrain.x(0), terrain.y(0));
    const Eigen::Vector2d cell = (at - from).cwiseQuotient(terrain.spacing());
    const auto x = static_cast<std::uint32_t>(cell.x()), y = static_cast<std::uint32_t>(cell.y());
    const Vector3d corner = terrain.point(x, y);
    const Vector3d normal = (terrain.point(x + 1, y) - corner).cross(terrain.point(x, y + 1) - corner).normalized();
    Quaterniond turned(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    if (on_its_side) turned = turned * Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY()));
    Isometry3d pose(Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal) * turned);
    const auto near = [&](std::uint32_t c, double spacing, std::uint32_t cells) {
        const auto reach = static_cast<std::uint32_t>(model.reach() / spacing) + 1;
        return std::pair(c - std::min(c, reach), std::min(c + reach + 1, cells));
    };
    const auto [x0, x1] = near(x, terrain.spacing().x(), terrain.cells_x());
    const auto [y0, y1] = near(y, terrain.spacing().y(), terrain.cells_y());
    const double above = terrain.bounds().max.z() + 2 * model.reach();
    pose.translation() = Vector3d(at.x(), at.y(), above);
    double way = above; // the terrain's heights are at least 0
    for (std::uint32_t v = y0; v < y1; ++v)
        for (std::uint32_t u = x0; u < x1; ++u)
            for (const std::uint32_t k : {0u, 1u}) {
                const auto places = terrain.corners(2 * (v * terrain.cells_x() + u) + k);
                std::array<Vector3d, 3> triangle;
                for (std::size_t c : {0u, 1u, 2u}) triangle[c] = terrain.point(places[c].column, places[c].row);
                way = std::min(way, way_until_touching(convex_of(triangle), Isometry3d::Identity(), model.convex(),
                                                       pose, -Vector3d::UnitZ()));
            }
    pose.translation().z() -= way + sink;
    return pose;
}

} // namespace oncollide::tools
