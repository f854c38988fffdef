#include <oncollide/narrowphase/exact/common_corner.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// True if `side` . `edge` > 0 is certain for the exact edge. The components of edges are differences rounded once, by
/// 2^-53 of themselves, and the sum rounds at most three times more; products below 2^-1000 may underflow.
bool certainly_ahead(const Vector3d& side, const Vector3d& edge)
{
    return side.dot(edge) > 0x1p-49 * side.cwiseAbs().dot(edge.cwiseAbs()) + 0x1p-1000;
}

/// True if a plane through the edges' common start separates them. Tries the plane that bisects the angle between the
/// sums of the edges.
bool parted(const Vector3d& a1, const Vector3d& a2, const Vector3d& b1, const Vector3d& b2)
{
    const Vector3d sum_a = a1 + a2, sum_b = b1 + b2;
    const Vector3d side = sum_a * sum_b.norm() - sum_b * sum_a.norm();
    return certainly_ahead(side, a1) && certainly_ahead(side, a2) && certainly_ahead(-side, b1) &&
           certainly_ahead(-side, b2);
}

} // namespace

bool have_common_edge(const TrianglePoints& a, const TrianglePoints& b)
{
    int common = 0;
    for (const Vector3d& p : a)
        for (const Vector3d& q : b) common += p.x() == q.x() && p.y() == q.y() && p.z() == q.z();
    return common > 1 && a[0] != a[1] && a[1] != a[2] && a[2] != a[0] && b[0] != b[1] && b[1] != b[2] && b[2] != b[0];
}

std::optional<CommonCorner> only_common_corner(const TrianglePoints& a, const TrianglePoints& b)
{
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const Vector3d &p = a[i], &q = b[k];
            if (p.x() != q.x() || p.y() != q.y() || p.z() != q.z()) continue;
            if (parted(a[(i + 1) % 3] - p, a[(i + 2) % 3] - p, b[(k + 1) % 3] - p, b[(k + 2) % 3] - p))
                return CommonCorner{i, k};
            return std::nullopt;
        }
    return std::nullopt;
}

} // namespace oncollide
