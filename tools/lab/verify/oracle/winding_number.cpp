#include "verify/oracle/winding_number.hpp"

#include <cmath>
#include <numbers>

#include "truth/triangle_distance.hpp"

namespace oncollide::tools {

long double winding_number(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles,
                           const Eigen::Vector3d& point)
{
    const Vector3l from = point.cast<long double>();
    const auto seen = [&](std::uint32_t v) { return Vector3l(vertices[v].cast<long double>() - from); };
    long double sum = 0;
    for (const Triangle& t : triangles) {
        const Vector3l a = seen(t[0]), b = seen(t[1]), c = seen(t[2]);
        const long double la = a.norm(), lb = b.norm(), lc = c.norm();
        sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return sum / (2 * std::numbers::pi_v<long double>);
}

} // namespace oncollide::tools
