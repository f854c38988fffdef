// Two triangles that are near each other where rounded arithmetic finds distances badly: needles, slivers, caps, edges
// and faces that are nearly parallel, corners that are nearly one, sizes far apart.
#pragma once
#include <vector>

#include "verify/cases/triangle_families.hpp"

namespace oncollide {

struct NearFamily {
    std::string name;
    TwoTriangles (*make)(CaseNumbers&); ///< of sizes around 1, at the origin
};

inline std::ostream& operator<<(std::ostream& out, const NearFamily& family)
{
    return out << family.name;
}

const std::vector<NearFamily>& near_families();

/// A pair of the family: most are scaled by 2^-30 to 2^28, and some are moved far from the origin.
TwoTriangles draw_near(const NearFamily& family, std::uint64_t number);

} // namespace oncollide
