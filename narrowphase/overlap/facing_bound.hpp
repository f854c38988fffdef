#pragma once
#include <span>
#include <vector>

#include <oncollide/narrowphase/overlap/placed_faces.hpp>

namespace oncollide {

/// A bound on the radius of a ball that no face cuts and whose centre is in a box.
///
/// The distances from faces are convex functions of the centre. Their mean is convex for any weights, so its largest
/// value is at a corner of the box. The weights balance the directions to the faces, so that the mean hardly changes
/// within the box: between two parallel faces the mean of both distances is half the gap everywhere. The error of this
/// bound is of second order in the size of the box; the error of a single distance is of first order.
class FacingBound {
public:
    void clear() { faces_.clear(); }
    /// Adds a face near the box.
    /// @param way  from `point`, which all faces share, to the nearest point of the face
    void add(const PlacedFaces::Face& face, const Eigen::Vector3d& way);
    /// The bound, to rounding; infinite without faces, or if no weights were found for which it may be below `enough`.
    /// @param reach  the largest distance of the box's points from `point`
    double find(const Aabb& box, double reach, double enough);

private:
    struct Near {
        const PlacedFaces::Face* face;
        double distance;
        Eigen::Vector3d away; ///< unit, from the face
        double weight;
    };
    bool balance(double reach, double enough);

    std::vector<Near> faces_;
};

} // namespace oncollide
