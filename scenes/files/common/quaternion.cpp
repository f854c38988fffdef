#include <oncollide/scenes/files/common/quaternion.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

Eigen::Quaterniond quaternion_of(FunctionRef<std::string()> place, const Eigen::Vector4d& xyzw,
                                 std::vector<std::string>& warnings)
{
    const double length = xyzw.norm();
    if (!(length >= 1e-6 && length <= 1e6))
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: the quaternion ({}, {}, {}, {}) has length {:.3g}; it must be near 1", place(),
                                xyzw[0], xyzw[1], xyzw[2], xyzw[3], length));
    const double off = std::abs(length - 1);
    if (off > 1e-6) warnings.push_back(fmt::format("{}: quaternion of length {:.9g} normalised", place(), length));
    return Eigen::Quaterniond(off > 1e-12 ? Eigen::Vector4d(xyzw / length) : xyzw);
}

} // namespace oncollide
