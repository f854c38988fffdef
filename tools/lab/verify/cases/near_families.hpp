// Two triangles that are near each other where rounded arithmetic finds distances badly: needles, slivers, caps, edges
// and faces that are nearly parallel, corners that are nearly one, sizes far apart.
#pragma once
#include <random>
#include <vector>

#include "verify/cases/triangle_families.hpp"

namespace oncollide {

/// Random numbers of a case.
class CaseNumbers {
public:
    explicit CaseNumbers(std::uint64_t seed) : random_(seed) {}
    double real(double low, double high) { return low + (high - low) * std::ldexp(double(random_() >> 11), -53); }
    int number(int low, int high) { return low + int(random_() % std::uint64_t(high - low + 1)); }
    /// Between 2^low and 2^high, evenly by magnitude.
    double magnitude(int low, int high) { return std::ldexp(real(1, 2), number(low, high - 1)); }
    double sign() { return random_() & 1 ? 1 : -1; }
    Eigen::Vector3d vector() { return {real(-1, 1), real(-1, 1), real(-1, 1)}; }
    Eigen::Matrix3d rotation()
    {
        return Eigen::Quaterniond(real(-1, 1), real(-1, 1), real(-1, 1), real(-1, 1)).normalized().toRotationMatrix();
    }

private:
    std::mt19937_64 random_;
};

struct NearFamily {
    std::string name;
    TwoTriangles (*make)(CaseNumbers&); ///< of sizes around 1, at the origin
};

inline std::ostream& operator<<(std::ostream& out, const NearFamily& family)
{
    return out << family.name;
}

const std::vector<NearFamily>& near_families();

/// A pair of the family: most are scaled by 2^-30 to 2^30, and some are moved far from the origin.
TwoTriangles draw_near(const NearFamily& family, std::uint64_t number);

} // namespace oncollide
