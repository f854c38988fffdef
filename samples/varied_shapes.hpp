#pragma once
#include <cstdint>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/shape.hpp>

namespace oncollide {

// Solid shapes with random sizes, for the catalogue and the benchmarks of contacts. Private to the project.

/// Random numbers in a sequence of their own for each seed and number.
class ShapeDice {
public:
    ShapeDice(std::uint64_t seed, std::uint64_t number) : seed_(seed), number_(number) {}
    double between(double least, double most);
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(between(0, static_cast<double>(count))); }
    bool chance(double share) { return between(0, 1) < share; }
    Eigen::Vector3d direction();
    Eigen::Quaterniond rotation();
    /// A rotation by at most `angle`.
    Eigen::Quaterniond tilt(double angle);

private:
    std::uint64_t seed_, number_, drawn_ = 0;
};

enum class ShapeKind { sphere, box, capsule, hull, cylinder, cone, ellipsoid };
const char* name_of(ShapeKind kind);

/// A shape of this kind, 0.1 to 0.5 m large. @param points  of a hull; 0: 8 to 60
Shape draw_shape(ShapeKind kind, ShapeDice& dice, int points = 0);

} // namespace oncollide
