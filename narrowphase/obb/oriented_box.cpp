#include <oncollide/narrowphase/obb/oriented_box.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

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

void set_frame(BoxNode& node, const Vector3d& centre, double radius)
{
    for (int axis = 0; axis < 3; ++axis) node.origin[axis] = static_cast<float>(centre[axis]);
    // Centres lie in the sphere, and half-extents are below its radius; twice the radius leaves room for quantised
    // axes. The origin as a float may be off by 2^-24 of its size.
    const double most = 2 * (radius + 0x1p-23 * centre.norm());
    node.unit = std::max(static_cast<float>(most / most_place), 1e-30f);
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

bool holds(const BoxNode& node, unsigned k, const Vector3d& point)
{
    const Vector3d centre = centre_of(node, k), half = Vector3d(node.hx[k], node.hy[k], node.hz[k]) * double(node.unit);
    const Vector3d along = (axes_of(node, k).transpose() * (point - centre)).cwiseAbs();
    const double rounding = 0x1p-48 * (point.norm() + centre.norm());
    return (along.array() * (1 + 0x1p-21) <= half.array() + rounding).all();
}

TriangleRow row_of(std::span<const TrianglePoints> triangles, const Vector3d& from)
{
    // Divided by the size, so that squares of floats neither overflow nor underflow.
    double size = 1e-30;
    for (const TrianglePoints& t : triangles)
        for (std::size_t side = 1; side < 3; ++side) size = std::max(size, (t[side] - t[0]).cwiseAbs().maxCoeff());
    TriangleRow row{};
    row.size = static_cast<float>(size), row.lanes = static_cast<std::uint32_t>(triangles.size());
    const double scale = 1 / size;
    for (std::size_t k = 0; k < triangles.size(); ++k) {
        const TrianglePoints& t = triangles[k];
        for (int i = 0; i < 3; ++i) {
            row.corner[i][k] = static_cast<float>(t[0][i] - from[i]);
            for (std::size_t side = 0; side < 2; ++side)
                row.sides[side][i][k] = static_cast<float>((t[side + 1][i] - t[0][i]) * scale);
        }
    }
    return row;
}

StoredFrame frame_of(const BoxNode& node)
{
    return {{node.origin[0], node.origin[1], node.origin[2]}, node.unit};
}

void set_boxes(BoxNode& node, const StoredBoxes& boxes)
{
    const auto store = [](auto(&to)[8], const auto(&from)[8]) { std::ranges::copy(from, to); };
    store(node.x, boxes.place[0]), store(node.y, boxes.place[1]), store(node.z, boxes.place[2]);
    store(node.qw, boxes.turn[0]), store(node.qx, boxes.turn[1]), store(node.qy, boxes.turn[2]);
    store(node.qz, boxes.turn[3]);
    store(node.hx, boxes.half[0]), store(node.hy, boxes.half[1]), store(node.hz, boxes.half[2]);
}

void set_box(BoxNode& node, unsigned k, const Aabb& box)
{
    node.qw[k] = static_cast<std::int16_t>(quaternion_steps), node.qx[k] = node.qy[k] = node.qz[k] = 0;
    const double unit = node.unit;
    std::int16_t* const places[3] = {&node.x[k], &node.y[k], &node.z[k]};
    for (int axis = 0; axis < 3; ++axis) {
        const double steps = (box.centre()[axis] - double(node.origin[axis])) / unit;
        *places[axis] = static_cast<std::int16_t>(std::clamp(std::round(steps), -most_place, most_place));
    }
    const Vector3d place = centre_of(node, k);
    const Vector3d rounding = 0x1p-50 * box.max.cwiseAbs().cwiseMax(box.min.cwiseAbs());
    const Vector3d half = (box.max - place).cwiseMax(place - box.min) + rounding;
    std::uint16_t* const halves[3] = {&node.hx[k], &node.hy[k], &node.hz[k]};
    for (int axis = 0; axis < 3; ++axis)
        *halves[axis] =
            static_cast<std::uint16_t>(std::clamp(std::ceil(half[axis] / unit * (1 + 0x1p-20)), 0.0, most_half));
}

} // namespace oncollide
