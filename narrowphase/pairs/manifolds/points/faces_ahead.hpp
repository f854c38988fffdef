#pragma once
#include <span>
#include <vector>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

struct NumberedTriangle {
    std::uint32_t triangle;
    TrianglePoints points;
};

/// Faces that lines in one direction cross outward, as seen from the body that they bound. The depth of a point below a
/// face's plane, and two barycentric coordinates of the place above it, are linear in p - origin. Keeps its memory.
class FacesAhead {
public:
    struct Face {
        Eigen::Vector3d depth, second, third; ///< gradients
        double depth_0, second_0, third_0;    ///< values at the origin
        double error;                         ///< error bound of the depth, for positions that err by 1
        double size;                          ///< metres by which a place moves if the coordinates change by 1
        std::uint32_t triangle;
    };

    void set(std::span<const NumberedTriangle> all, const Eigen::Vector3d& direction);
    /// The nearest of the faces that the line through p crosses; null: none.
    /// @param depth  the depth of p along the direction; negative in front of the face; infinite without a face
    /// @param beside_by  metres: the line passes at most as far beside the face
    const Face* nearest(const Eigen::Vector3d& p, double& depth, double& beside_by) const;
    const std::vector<Face>& faces() const { return faces_; }

private:
    Eigen::Vector3d origin_;
    std::vector<Face> faces_;
};

} // namespace oncollide
