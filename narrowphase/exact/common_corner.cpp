#include <oncollide/narrowphase/exact/common_corner.hpp>

#include <oncollide/narrowphase/exact/neighbours.hpp>

namespace oncollide {

using Eigen::Vector3d;

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
            if (certainly_share_corner_only(p, a[(i + 1) % 3], a[(i + 2) % 3], b[(k + 1) % 3], b[(k + 2) % 3]))
                return CommonCorner{i, k};
            return std::nullopt;
        }
    return std::nullopt;
}

} // namespace oncollide
