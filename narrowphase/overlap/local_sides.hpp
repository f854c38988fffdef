#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include <Eigen/Core>

#include <oncollide/narrowphase/overlap/placed_faces.hpp>

namespace oncollide {

/// A solid within a ball that its surface divides by at most three flat faces: which of the regions between the faces'
/// planes are outside, and half-spaces that hold all of the solid in the ball. Coordinates are relative to the ball's
/// centre.
class LocalSides {
public:
    /// @param near    the numbers of all faces that meet the ball
    /// @param thick   the corners of a face count as one plane if they lie between two planes this far apart
    /// @param winding  of the surface around the centre, which is not on it
    /// Returns false if there are more than three planes; then the rest is not set.
    bool set(const PlacedFaces& solid, std::span<const std::uint32_t> near, const Eigen::Vector3d& centre,
             double radius, double thick, int winding);

    /// An upper bound on how deep a point of both solids, within `inner` of the centre, lies below the surface of one
    /// of them; 0 if no point of both is there; infinite if the half-spaces do not bound it.
    /// @param inner  less than the radius of both
    /// @param deep   set to a point that may be deep: midway between the nearest planes that face each other
    static double depth(const LocalSides& a, const LocalSides& b, double inner, Eigen::Vector3d& deep);

    /// Bounds on the volume of both solids in a box within the ball, relative to its centre; to rounding.
    static std::pair<double, double> volume(const LocalSides& a, const LocalSides& b, const Aabb& box);

private:
    static constexpr int most = 3;
    struct Slab {
        Eigen::Vector3d normal;
        double low, high;
    };
    /// The points x with normal . x >= from.
    struct HalfSpace {
        Eigen::Vector3d normal;
        double from;
    };
    enum class Side : std::uint8_t { unknown, inside, outside };

    bool add(const PlacedFaces::Face& face, const Eigen::Vector3d& centre, double thick);
    void locate(const PlacedFaces& solid, std::span<const std::uint32_t> near, const Eigen::Vector3d& centre,
                int winding);
    void find_holding();
    /// The region's number: bit k is set above slab k; -1 within a slab.
    int region_of(const Eigen::Vector3d& point) const;
    /// The half-space on one side of a slab, with the slab (`with`) or without it.
    HalfSpace half_space(int slab, bool above, bool with) const;
    bool empty(int region, int slab, bool above) const;
    static double reach(const HalfSpace& h, const Eigen::Vector3d& along, double inner);
    /// The length of a translation that moves every point of the region, slabs included, into the region across a slab.
    double way_across(int region, int slab, double width) const;

    int count_ = 0, holding_count_ = 0;
    double radius_ = 0;
    std::array<Slab, most> slabs_{};
    std::array<Side, 1 << most> sides_{};       ///< by region
    std::array<HalfSpace, 2 * most> holding_{}; ///< half-spaces without a point of the solid: it is beyond their planes
    bool crossable_ = false;                    ///< no two planes are nearly parallel
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most> inverse_; ///< if so: of normals * normals^T
};

} // namespace oncollide
