#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <oncollide/narrowphase/model.hpp>

#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {

constexpr std::array<std::string_view, 8> shape_kinds{"sphere", "box",       "capsule", "cylinder",
                                                      "hull",   "ellipsoid", "cone",    "half_space"};

/// A shape in both libraries' forms.
struct RacedShape {
    std::unique_ptr<Model> model;
    FclGeometry fcl;
};

/// Two shapes close to contact: along some direction they are apart by a gap, or overlap by this length, which is
/// random between the least gap and 0.1 m, each power of ten equally likely. Sizes are 0.1 to 1 m.
struct ClosePair {
    const RacedShape *a, *b;
    int kind_a, kind_b; ///< indices in shape_kinds, kind_a <= kind_b
    Eigen::Isometry3d pose_a, pose_b;
};

/// Generates close pairs of all kinds; equal seeds and numbers give equal pairs.
class ClosePairs {
public:
    ClosePairs(std::uint64_t seed, double least_gap);
    ClosePair draw(std::uint64_t number) const;

private:
    static constexpr std::size_t of_a_kind = 64;
    std::uint64_t seed_;
    double least_gap_;
    std::vector<RacedShape> shapes_; ///< of_a_kind shapes of each kind
};

} // namespace oncollide::tools
