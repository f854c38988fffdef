#pragma once
#include <span>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/cpu_features.hpp>
#include <oncollide/narrowphase/boxes/oriented_box_kernel.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const OrientedBoxKernel& oriented_box_kernel()
{
    static const OrientedBoxKernel kernel = ONCOLLIDE_CHOOSE(oriented_box_kernel);
    return kernel;
}

/// A box around points, not yet quantised: axes are the columns of a rotation.
struct OrientedBox {
    Eigen::Vector3d centre, half;
    Eigen::Matrix3d axes;
};

/// A box with axes along the directions in which the triangles' surface spreads most and least; for one triangle, along
/// its normal and its longest side; but along the mesh's own axes where that takes less area and is not thicker.
/// Source: Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996.
OrientedBox fit_box(std::span<const TrianglePoints> triangles);

/// Sets the node's frame, so that the numbers of boxes around parts of the ball fit.
void set_frame(BoxNode& node, const Eigen::Vector3d& centre, double radius);

/// The centre of box k, and how far its points are from there at most.
Eigen::Vector3d centre_of(const BoxNode& node, unsigned k);
double radius_of(const BoxNode& node, unsigned k);

/// Stores a box around the triangles as box k, its axes near those of `box`. Conservative: the box as the box test will
/// read it holds every point of the triangles.
void quantise(BoxNode& node, unsigned k, const OrientedBox& box, std::span<const TrianglePoints> triangles);
/// The same of a box along the axes of the tree's frame.
void quantise_along_axes(BoxNode& node, unsigned k, const Aabb& box);

} // namespace oncollide
