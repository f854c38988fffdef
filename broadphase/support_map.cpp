#include <oncollide/broadphase/support_map.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/broadphase/box_kernel.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3f;

/// Of a direction: the face of the cube that it goes through, and where, from -1 to 1 each.
struct OnCube {
    std::uint32_t face;
    float u, v;

    explicit OnCube(const Vector3f& d)
    {
        int axis;
        const float most = d.cwiseAbs().maxCoeff(&axis);
        face = 2 * static_cast<std::uint32_t>(axis) + (d[axis] < 0);
        u = d[(axis + 1) % 3] / most, v = d[(axis + 2) % 3] / most;
    }
};

Vector3f direction(std::uint32_t face, float u, float v)
{
    const int axis = static_cast<int>(face / 2);
    Vector3f d;
    d[axis] = face % 2 ? -1.0f : 1.0f, d[(axis + 1) % 3] = u, d[(axis + 2) % 3] = v;
    return d.normalized();
}

} // namespace

PointColumns point_columns(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre)
{
    PointColumns columns;
    for (std::vector<float>& column : columns.xyz) column.reserve((points.size() + 7) / 8 * 8);
    for (const Eigen::Vector3d& point : points) {
        const Vector3f p = (point - centre).cast<float>();
        columns.add(p.x(), p.y(), p.z());
    }
    while (columns.size() % 8) columns.add(columns, 0);
    return columns;
}

PointColumns used_points(const Mesh& mesh, const Eigen::Vector3d& centre)
{
    std::vector<bool> seen(mesh.vertices.size());
    std::vector<Eigen::Vector3d> points;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t)
            if (!seen[v]) seen[v] = true, points.push_back(mesh.vertices[v]);
    return point_columns(points, centre);
}

/// Fills the cells from whole faces down: what cannot be farthest along any direction of a square cannot be so along
/// any of a part of it.
class SupportMap::Filling {
public:
    Filling(SupportMap& map, const PointColumns& points) : map_(map)
    {
        float reach = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
            reach = std::max(reach, std::hypot(points.xyz[0][i], points.xyz[1][i], points.xyz[2][i]));
        // Products and sums err by a quarter of that, and a direction on an edge may be taken for a neighbour's.
        rounding_ = 0x1p-19f * reach;
        for (std::uint32_t face = 0; face < 6; ++face) divide(face, 0, 0, map.side_, points);
    }

private:
    /// @param x, y   of a square of cells of the face
    /// @param among  all that may be farthest along one of its directions
    void divide(std::uint32_t face, std::uint32_t x, std::uint32_t y, std::uint32_t side, const PointColumns& among)
    {
        const PointColumns left = farthest(face, x, y, side, among);
        if (side == 1) {
            for (std::size_t i = 0; i < left.size(); ++i) map_.points_.add(left, i);
            while (map_.points_.size() % 8) map_.points_.add(left, 0);
            map_.ends_.push_back(static_cast<std::uint32_t>(map_.points_.size()));
            return;
        }
        const std::uint32_t half = side / 2;
        for (std::uint32_t k = 0; k < 4; ++k) divide(face, x + (k & 1) * half, y + (k >> 1) * half, half, left);
    }
    /// Directions of the square are sums of those at its corners, with weights that are not negative: what another
    /// point exceeds along all four is exceeded along every one. The others tried are those farthest along the four
    /// and along their sum.
    PointColumns farthest(std::uint32_t face, std::uint32_t x, std::uint32_t y, std::uint32_t side,
                          const PointColumns& among)
    {
        const auto at = [&](std::uint32_t cell) {
            return 2 * static_cast<float>(cell) / static_cast<float>(map_.side_) - 1;
        };
        const float u[] = {at(x), at(x + side)}, v[] = {at(y), at(y + side)};
        const std::size_t count = among.size();
        for (std::vector<float>& column : along_) column.resize(count);
        const float *px = among.xyz[0].data(), *py = among.xyz[1].data(), *pz = among.xyz[2].data();
        for (unsigned k = 0; k < 4; ++k) {
            const Vector3f d = direction(face, u[k & 1], v[k >> 1]);
            const float dx = d.x(), dy = d.y(), dz = d.z();
            float* const out = along_[k].data();
            for (std::size_t i = 0; i < count; ++i) out[i] = dx * px[i] + dy * py[i] + dz * pz[i];
        }
        const float *a0 = along_[0].data(), *a1 = along_[1].data(), *a2 = along_[2].data(), *a3 = along_[3].data();
        float* const sum = along_[4].data();
        for (std::size_t i = 0; i < count; ++i) sum[i] = (a0[i] + a1[i]) + (a2[i] + a3[i]);
        float bar[5][4]; // what one of the others has along each corner, less rounding
        for (unsigned k = 0; k < 5; ++k) {
            const float most = Eigen::Map<const Eigen::ArrayXf>(along_[k].data(), Eigen::Index(count)).maxCoeff();
            const std::size_t other = std::size_t(std::ranges::find(along_[k], most) - along_[k].begin());
            for (unsigned c = 0; c < 4; ++c) bar[k][c] = along_[c][other] - rounding_;
        }
        keep_.resize(count);
        int* const keep = keep_.data();
        for (std::size_t i = 0; i < count; ++i) {
            int every = 1;
            for (const auto& b : bar) every &= (a0[i] >= b[0]) | (a1[i] >= b[1]) | (a2[i] >= b[2]) | (a3[i] >= b[3]);
            keep[i] = every;
        }
        PointColumns left;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float* const from = among.xyz[axis].data();
            std::vector<float>& column = left.xyz[axis];
            column.resize(count);
            std::size_t kept = 0;
            for (std::size_t i = 0; i < count; ++i) column[kept] = from[i], kept += std::size_t(keep[i]);
            column.resize(kept);
        }
        return left;
    }

    SupportMap& map_;
    float rounding_;
    std::array<std::vector<float>, 5> along_; ///< by point
    std::vector<int> keep_;
};

SupportMap::SupportMap(const PointColumns& points) : side_(2)
{
    while (side_ < 32 && 256 * std::size_t(side_) * side_ < points.size()) side_ *= 2;
    Filling(*this, points);
    for (std::vector<float>& column : points_.xyz) column.shrink_to_fit();
}

float SupportMap::most(const Vector3f& d) const
{
    const OnCube at(d);
    const auto cell = [&](float u) {
        return std::min(static_cast<std::uint32_t>(0.5f * (u + 1) * static_cast<float>(side_)), side_ - 1);
    };
    // Cells are in the order in which squares are divided: by the bits of y and x in turn.
    std::uint32_t number = 0;
    const std::uint32_t x = cell(at.u), y = cell(at.v);
    for (std::uint32_t bit = side_ / 2; bit; bit /= 2) number = 4 * number + 2 * ((y & bit) != 0) + ((x & bit) != 0);
    number += at.face * side_ * side_;
    const std::uint32_t begin = number ? ends_[number - 1] : 0;
    return box_kernel().most_along(&points_.xyz[0][begin], &points_.xyz[1][begin], &points_.xyz[2][begin],
                                   ends_[number] - begin, d.data());
}

} // namespace oncollide
