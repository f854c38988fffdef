#pragma once
#include <vector>

#include <oncollide/scenes/deformation.hpp>

namespace oncollide {

/// Cloth in wind: waves travel from a fixed edge to the free end, and grow on their way. Each line of the cloth away
/// from the edge keeps its length; only its direction changes, by the sum of the waves. Closed form; equal bits on
/// every platform.
class Flutter final : public Deformation {
public:
    struct Wave {
        double angle;  ///< radians, far from the edge
        double length; ///< metres, > 0
        double period; ///< frames, > 0
        double slant;  ///< turns of its phase per metre beside the line
        double phase;  ///< turns
    };

    /// Throws Error{bad_data} for numbers that are not finite or out of range, and directions that are not of length 1
    /// or not perpendicular, to 1e-6.
    void check() const;
    void move(const Mesh& rest, double time, std::span<Eigen::Vector3d> positions) override;

    Eigen::Vector3d edge = Eigen::Vector3d::Zero();   ///< a point of the fixed edge
    Eigen::Vector3d along = Eigen::Vector3d::UnitX(); ///< from the edge into the cloth at rest; behind it nothing moves
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ(); ///< of the cloth at rest
    double growth = 1; ///< metres, > 0: the distance from the edge at which waves have half of their angle
    std::vector<Wave> waves;

private:
    double angle(double distance, double beside, double time) const;
};

} // namespace oncollide
