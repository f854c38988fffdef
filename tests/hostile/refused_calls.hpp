#pragma once
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>

namespace oncollide::test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

/// Poses that no call accepts.
inline std::vector<Eigen::Isometry3d> bad_poses()
{
    std::vector<Eigen::Isometry3d> poses(5, Eigen::Isometry3d::Identity());
    poses[0].translation().y() = nan, poses[1].translation().x() = 1e300, poses[2].linear().col(0) *= -1;
    poses[3].linear() *= 2, poses[4].matrix()(3, 0) = 1;
    return poses;
}

using Calls = std::map<std::string, std::function<void()>>;

/// Each call throws an Error that is no internal fault, on one line.
inline void expect_refused(const Calls& calls)
{
    for (const auto& [name, call] : calls) try {
            call();
            ADD_FAILURE() << name << ": accepted";
        } catch (const Error& error) {
            EXPECT_TRUE(error.kind() == ErrorKind::usage || error.kind() == ErrorKind::bad_data) << name;
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
            EXPECT_GT(std::string(error.what()).size(), 10u) << name;
        } catch (const std::exception& other) {
            ADD_FAILURE() << name << ": " << other.what();
        }
}

} // namespace oncollide::test
