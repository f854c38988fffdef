#include <oncollide/narrowphase/boxes/oriented_box.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double quaternion_steps = 32767;
constexpr double most_centre = 32767, most_half = 65535;

/// A triangle on a grid of 2^15 steps.
struct GridTriangle {
    std::array<Eigen::Matrix<std::int64_t, 3, 1>, 3> corners;
    double area; ///< twice

    GridTriangle() = default;
    GridTriangle(const TrianglePoints& t, const Vector3d& middle, double half)
    {
        for (std::size_t k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis) {
                const double x = (t[k][axis] - middle[axis]) / half * 0x1p14;
                corners[k][axis] = static_cast<std::int64_t>(x + std::copysign(0.5, x));
            }
        area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).cast<double>().norm();
    }
};

/// Second moments of the surface; of the corners when it has no area. In integers, so that the order of triangles and
/// corners does not show, not even where all directions are alike.
Matrix3d spread_of(std::span<const TrianglePoints> triangles)
{
    using Vector = Eigen::Matrix<std::int64_t, 3, 1>;
    using Matrix = Eigen::Matrix<std::int64_t, 3, 3>;
    Aabb extent;
    for (const TrianglePoints& t : triangles)
        for (const Vector3d& p : t) extent.add(p);
    const double half = extent.half_extent().maxCoeff();
    if (!(half > 0)) return Matrix3d::Zero();
    std::array<GridTriangle, 16> on_stack;
    std::vector<GridTriangle> many(triangles.size() > on_stack.size() ? triangles.size() : 0);
    const std::span<GridTriangle> grid = many.empty() ? std::span(on_stack).first(triangles.size()) : std::span(many);
    double largest = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        grid[i] = GridTriangle(triangles[i], extent.centre(), half);
        largest = std::max(largest, grid[i].area);
    }
    // A term of the sum is below 2^32 times its weight.
    const double heaviest = triangles.size() < std::size_t(1) << 20 ? 1024 : 1;
    Matrix squares = Matrix::Zero();
    Vector sum = Vector::Zero();
    std::int64_t weights = 0;
    for (const GridTriangle& t : grid) {
        const auto& [p, q, r] = t.corners;
        const Vector s = p + q + r;
        const double share = heaviest * t.area / largest;
        const auto whole = largest > 0 ? std::int64_t(share) : 1;
        const std::int64_t weight = whole + (largest > 0 && double(whole) < share);
        // Twelve times the integral of x x' over a triangle of area 1.
        squares += weight * (s * s.transpose() + p * p.transpose() + q * q.transpose() + r * r.transpose());
        sum += weight * s, weights += weight;
    }
    const double w = double(weights);
    const Vector3d mean = sum.cast<double>() / (3 * w);
    return squares.cast<double>() / (12 * w) - mean * mean.transpose();
}

/// Right-handed, the first axis along u, the last along n as far as that is square to u.
Matrix3d frame_of(const Vector3d& u, const Vector3d& n)
{
    Matrix3d axes;
    axes.col(0) = u.normalized();
    axes.col(2) = (n - axes.col(0) * axes.col(0).dot(n)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
}

Matrix3d axes_of_triangle(TrianglePoints t)
{
    std::sort(t.begin(), t.end(), [](const Vector3d& p, const Vector3d& q) {
        return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
    });
    Vector3d longest = t[1] - t[0];
    for (const Vector3d& side : {Vector3d(t[2] - t[1]), Vector3d(t[0] - t[2])})
        if (side.squaredNorm() > longest.squaredNorm()) longest = side;
    const double length = longest.norm();
    if (!(length > 0)) return Matrix3d::Identity();
    const Vector3d u = longest / length;
    Vector3d n = u.cross(Vector3d((t[1] - t[0]) / length)) + u.cross(Vector3d((t[2] - t[0]) / length));
    if (!(n.norm() > 1e-12)) n = u.unitOrthogonal();
    const Matrix3d axes = frame_of(u, n.normalized());
    return axes.allFinite() ? axes : Matrix3d::Identity();
}

Matrix3d axes_of_many(std::span<const TrianglePoints> triangles)
{
    const Matrix3d spread = spread_of(triangles);
    if (!(spread.cwiseAbs().maxCoeff() > 0)) return Matrix3d::Identity();
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(spread);
    const Matrix3d axes = frame_of(solver.eigenvectors().col(2), solver.eigenvectors().col(0));
    return axes.allFinite() ? axes : Matrix3d::Identity();
}

/// The axes of box k as the box test reads them: the same operations in the same order.
Matrix3d axes_of(const BoxNode& node, unsigned k)
{
    float w = float(node.qw[k]) * (1.0f / 32767), x = float(node.qx[k]) * (1.0f / 32767),
          y = float(node.qy[k]) * (1.0f / 32767), z = float(node.qz[k]) * (1.0f / 32767);
    const float stretch = 1.5f - 0.5f * (w * w + x * x + y * y + z * z);
    w = w * stretch, x = x * stretch, y = y * stretch, z = z * stretch;
    const float x2 = x + x, y2 = y + y, z2 = z + z;
    const float xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2, wx = w * x2, wy = w * y2,
                wz = w * z2;
    Matrix3d axes;
    axes.col(0) = Eigen::Vector3f(1 - (yy + zz), xy + wz, xz - wy).cast<double>();
    axes.col(1) = Eigen::Vector3f(xy - wz, 1 - (xx + zz), yz + wx).cast<double>();
    axes.col(2) = Eigen::Vector3f(xz + wy, yz - wx, 1 - (xx + yy)).cast<double>();
    return axes;
}

} // namespace

OrientedBox fit_box(std::span<const TrianglePoints> triangles)
{
    const Matrix3d axes = triangles.size() == 1 ? axes_of_triangle(triangles[0]) : axes_of_many(triangles);
    Aabb along, straight;
    for (const TrianglePoints& t : triangles)
        for (const Vector3d& p : t) along.add(axes.transpose() * p), straight.add(p);
    const auto area = [](const Vector3d& h) { return h.x() * h.y() + h.y() * h.z() + h.z() * h.x(); };
    // Where things are built along the axes these fit better; but a thicker box bounds a curved surface worse.
    const Vector3d half = straight.half_extent(), fitted = along.half_extent();
    if (area(half) < 0.95 * area(fitted) && half.minCoeff() <= 1.25 * fitted.minCoeff())
        return {straight.centre(), half, Matrix3d::Identity()};
    return {axes * along.centre(), along.half_extent(), axes};
}

void set_frame(BoxNode& node, const Vector3d& centre, double radius)
{
    for (int axis = 0; axis < 3; ++axis) node.origin[axis] = static_cast<float>(centre[axis]);
    // Centres lie in the ball, half-extents are below its radius; twice that leaves room for quantised axes. The origin
    // as a float may be off by 2^-24 of its size.
    const double most = 2 * (radius + 0x1p-23 * centre.norm());
    node.unit = std::max(static_cast<float>(most / most_centre), 1e-30f);
}

Vector3d centre_of(const BoxNode& node, unsigned k)
{
    const std::int16_t places[3] = {node.x[k], node.y[k], node.z[k]};
    Vector3d centre;
    for (int axis = 0; axis < 3; ++axis) centre[axis] = node.origin[axis] + double(places[axis]) * node.unit;
    return centre;
}

double radius_of(const BoxNode& node, unsigned k)
{
    return Vector3d(node.hx[k], node.hy[k], node.hz[k]).norm() * double(node.unit) * (1 + 0x1p-20);
}

void quantise(BoxNode& node, unsigned k, const OrientedBox& box, std::span<const TrianglePoints> triangles)
{
    const Eigen::Quaterniond q(box.axes);
    const auto part = [](double x) { return static_cast<std::int16_t>(std::round(quaternion_steps * x)); };
    node.qw[k] = part(q.w()), node.qx[k] = part(q.x()), node.qy[k] = part(q.y()), node.qz[k] = part(q.z());
    const Matrix3d axes = axes_of(node, k);

    const double unit = node.unit;
    std::int16_t* const places[3] = {&node.x[k], &node.y[k], &node.z[k]};
    for (int axis = 0; axis < 3; ++axis) {
        const double steps = (box.centre[axis] - double(node.origin[axis])) / unit;
        *places[axis] = static_cast<std::int16_t>(std::clamp(std::round(steps), -most_centre, most_centre));
    }
    const Vector3d centre = centre_of(node, k);
    Vector3d half = Vector3d::Zero();
    for (const TrianglePoints& t : triangles)
        for (const Vector3d& p : t) half = half.cwiseMax((axes.transpose() * (p - centre)).cwiseAbs());
    std::uint16_t* const halves[3] = {&node.hx[k], &node.hy[k], &node.hz[k]};
    for (int axis = 0; axis < 3; ++axis)
        *halves[axis] = static_cast<std::uint16_t>(std::min(std::ceil(half[axis] / unit * (1 + 0x1p-20)), most_half));
}

void quantise_along_axes(BoxNode& node, unsigned k, const Aabb& box)
{
    const TrianglePoints diagonal{box.min, box.max, box.max};
    quantise(node, k, {box.centre(), box.half_extent(), Matrix3d::Identity()}, {&diagonal, 1});
}

} // namespace oncollide
