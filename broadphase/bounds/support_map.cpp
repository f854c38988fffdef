#include <oncollide/broadphase/bounds/support_map.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3f;

constexpr std::uint32_t few = 16;       // points: scanning fewer is no faster
constexpr std::uint32_t most_side = 64; // cells
/// Dividing a list costs about as much as scanning it this many times.
constexpr std::uint32_t looks_that_pay = 16;

Vector3f direction(std::uint32_t face, float u, float v)
{
    const int axis = static_cast<int>(face / 2);
    Vector3f d;
    d[axis] = face % 2 ? -1.0f : 1.0f, d[(axis + 1) % 3] = u, d[(axis + 2) % 3] = v;
    return d.normalized();
}

/// Pads to a multiple of 8 with copies of the point at `first`.
void pad(PointColumns& points, std::size_t first)
{
    while (points.size() % 8) points.add(points, first);
}

} // namespace

PointColumns point_columns(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre)
{
    PointColumns columns;
    set_columns(columns, points, centre);
    return columns;
}

void set_columns(PointColumns& columns, std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre)
{
    for (std::vector<float>& column : columns.xyz) column.reserve((points.size() + 7) / 8 * 8), column.clear();
    for (const Eigen::Vector3d& point : points) {
        const Vector3f p = (point - centre).cast<float>();
        columns.add(p.x(), p.y(), p.z());
    }
    pad(columns, 0);
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

SupportMap::SupportMap(PointColumns points) : side_(2), points_(std::move(points))
{
    ONCOLLIDE_ASSERT(points_.size() > 0 && points_.size() % 8 == 0);
    const auto& [x, y, z] = points_.xyz;
    float reach2 = 0;
    for (std::size_t i = 0; i < x.size(); ++i) reach2 = std::max(reach2, x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    // Products and sums err by a quarter of this; also, a direction on a cell's edge may be assigned to the neighbour.
    rounding_ = 0x1p-19f * std::sqrt(reach2);
    while (side_ < most_side && 64 * std::size_t(side_) * side_ < points_.size()) side_ *= 2;
    const PointRange all{0, static_cast<std::uint32_t>(points_.size())};
    cells_.assign(std::size_t(6) * side_ * side_, all);
    squares_.push_back({all, 2 * side_, 0});
    square_of_.assign(cells_.size(), 0);
}

inline std::uint32_t SupportMap::cell(std::uint32_t face, float u, float v) const
{
    const auto along = [this](float t) {
        return std::min(static_cast<std::uint32_t>(0.5f * (t + 1) * static_cast<float>(side_)), side_ - 1);
    };
    return (face * side_ + along(v)) * side_ + along(u);
}

/// The cells of the rows and of their opposites.
inline std::array<std::uint32_t, 6> SupportMap::cells_along(const Eigen::Matrix3f& rows) const
{
    std::array<std::uint32_t, 6> cells;
    for (unsigned row = 0; row < 3; ++row) {
        const float d[] = {rows(row, 0), rows(row, 1), rows(row, 2)};
        const float x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
        const std::uint32_t axis = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
        const float most = std::max(x, std::max(y, z)), u = d[(axis + 1) % 3] / most, v = d[(axis + 2) % 3] / most;
        const std::uint32_t face = 2 * axis + (d[axis] < 0);
        cells[2 * row] = cell(face, u, v), cells[2 * row + 1] = cell(face ^ 1, -u, -v);
    }
    return cells;
}

inline bool SupportMap::divisible(const Square& square)
{
    return square.points.count > few && square.side > 1;
}

/// Gives the quarter of the square around `cell` its own list; if the square is the whole cube, the face.
void SupportMap::divide(std::uint32_t cell)
{
    ONCOLLIDE_ASSERT(cell < square_of_.size() && divisible(squares_[square_of_[cell]]));
    const Square& whole = squares_[square_of_[cell]];
    const std::uint32_t side = whole.side / 2, face = cell / (side_ * side_);
    const std::uint32_t x = cell % side_ / side * side, y = cell / side_ % side_ / side * side;
    const PointRange points = farthest(face, x, y, side, whole.points);
    for (std::uint32_t row = y; row < y + side; ++row) {
        const std::size_t first = (std::size_t(face) * side_ + row) * side_ + x;
        std::fill_n(cells_.begin() + std::ptrdiff_t(first), side, points);
        std::fill_n(square_of_.begin() + std::ptrdiff_t(first), side, static_cast<std::uint32_t>(squares_.size()));
    }
    squares_.push_back({points, side, 0});
}

/// Appends the points of a list that can be support points along a direction of a square.
///
/// Its directions are combinations of the four corner directions with non-negative weights, so a point that another
/// exceeds along all four is never a support point. Only five other points are tried: the support points along the four
/// directions and along their sum.
PointRange SupportMap::farthest(std::uint32_t face, std::uint32_t x, std::uint32_t y, std::uint32_t side,
                                PointRange among)
{
    const auto at = [&](std::uint32_t cell) { return 2 * static_cast<float>(cell) / static_cast<float>(side_) - 1; };
    const float u[] = {at(x), at(x + side)}, v[] = {at(y), at(y + side)};
    float corners[4][3];
    for (std::size_t c = 0; c < 4; ++c) {
        const Vector3f d = direction(face, u[c & 1], v[c >> 1]);
        std::copy_n(d.data(), 3, corners[c]);
    }
    ONCOLLIDE_ASSERT(among.count > 0 && among.begin + among.count <= points_.size() && x + side <= side_ &&
                     y + side <= side_);
    const std::size_t count = among.count, room = (count + 7) / 8 * 8;
    const auto& [px, py, pz] = points_.xyz;
    if (keep_.size() < room) along_.resize(5 * room), keep_.resize(room);
    aabb_kernel().keep_farthest(&px[among.begin], &py[among.begin], &pz[among.begin], among.count, corners, rounding_,
                                along_.data(), keep_.data());
    const auto begin = static_cast<std::uint32_t>(points_.size());
    for (std::vector<float>& column : points_.xyz) {
        column.resize(begin + count);
        const float* const from = &column[among.begin];
        float* to = &column[begin];
        for (std::size_t i = 0; i < count; ++i) *to = from[i], to += keep_[i];
        column.resize(std::size_t(to - column.data()));
    }
    const auto kept = static_cast<std::uint32_t>(points_.size() - begin);
    pad(points_, begin);
    return {begin, kept};
    ONCOLLIDE_ASSERT(kept > 0 && kept <= count);
}

void SupportMap::prepare(const Eigen::Matrix3f& rows)
{
    for (const std::uint32_t cell : cells_along(rows)) {
        const auto pays = [](Square& square) {
            return divisible(square) && (square.looks += boxes_a_look) > looks_that_pay;
        };
        while (pays(squares_[square_of_[cell]])) divide(cell);
    }
}

void SupportMap::complete()
{
    for (std::uint32_t cell = 0; cell < cells_.size(); ++cell)
        while (divisible(squares_[square_of_[cell]])) divide(cell);
    PointColumns packed; // drops lists that no cell uses any more
    for (Square& square : squares_) square.side = 0;
    for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
        Square& square = squares_[square_of_[cell]];
        if (square.side == 0) {
            const std::size_t begin = packed.size();
            for (std::size_t i = 0; i < square.points.count; ++i) packed.add(points_, square.points.begin + i);
            pad(packed, begin);
            square.points.begin = static_cast<std::uint32_t>(begin), square.side = 1;
        }
        cells_[cell] = square.points;
    }
    for (std::vector<float>& column : packed.xyz) column.shrink_to_fit();
    points_ = std::move(packed), squares_ = {}, square_of_ = {}, along_ = {}, keep_ = {};
}

void SupportMap::box(const Eigen::Matrix3f& rows, Vector3f& lo, Vector3f& hi) const
{
    ONCOLLIDE_ASSERT(!empty() && rows.allFinite());
    const std::array<std::uint32_t, 6> cells = cells_along(rows);
    PointRange lists[6];
    for (unsigned k = 0; k < 6; ++k) lists[k] = cells_[cells[k]];
    const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> by_rows = rows;
    const auto& [x, y, z] = points_.xyz;
    aabb_kernel().lists_box(x.data(), y.data(), z.data(), lists, by_rows.data(), lo.data(), hi.data());
    ONCOLLIDE_ASSERT((lo.array() <= hi.array()).all());
}

std::size_t SupportMap::bytes() const
{
    return points_.bytes() + cells_.capacity() * sizeof(PointRange) + squares_.capacity() * sizeof(Square) +
           (square_of_.capacity() + along_.capacity() + keep_.capacity()) * sizeof(std::uint32_t);
}

} // namespace oncollide
