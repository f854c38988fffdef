#pragma once
#include <cmath>
#include <concepts>
#include <cstdint>
#include <random>
#include <type_traits>

#include <Eigen/Geometry>

namespace oncollide {

/// Random numbers of a case.
class CaseNumbers {
public:
    explicit CaseNumbers(std::uint64_t seed) : random_(seed) {}

    template <std::integral Integer>
    Integer number(Integer low, std::type_identity_t<Integer> high)
    {
        return std::uniform_int_distribution<Integer>(low, high)(random_);
    }
    bool one_in(int n) { return number(1, n) == 1; }
    double real(double low, double high) { return low + (high - low) * std::ldexp(double(random_() >> 11), -53); }
    /// Between 2^low and 2^high, evenly by magnitude.
    double magnitude(int low, int high) { return std::ldexp(real(1, 2), number(low, high - 1)); }
    int sign() { return number(0, 1) ? 1 : -1; }
    Eigen::Vector3d vector() { return {real(-1, 1), real(-1, 1), real(-1, 1)}; }
    Eigen::Matrix3d rotation()
    {
        return Eigen::Quaterniond(real(-1, 1), real(-1, 1), real(-1, 1), real(-1, 1)).normalized().toRotationMatrix();
    }

protected:
    std::mt19937_64 random_;
};

} // namespace oncollide
