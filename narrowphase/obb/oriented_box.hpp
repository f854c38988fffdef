#pragma once
#include <span>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/cpu_features.hpp>
#include <oncollide/narrowphase/obb/box_fit.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const OrientedBoxKernel& oriented_box_kernel()
{
    static const OrientedBoxKernel kernel = ONCOLLIDE_CHOOSE(oriented_box_kernel);
    return kernel;
}

/// Sets the node's frame, so that the numbers of boxes around parts of the ball fit.
void set_frame(BoxNode& node, const Eigen::Vector3d& centre, double radius);

/// The centre of box k, and how far its points are from there at most.
Eigen::Vector3d centre_of(const BoxNode& node, unsigned k);
double radius_of(const BoxNode& node, unsigned k);
/// Is a point of the tree's frame in box k, as quantise() would have it?
bool holds(const BoxNode& node, unsigned k, const Eigen::Vector3d& point);

/// Eight triangles at most, for the kernel: it makes boxes of them that hold their corners, off by less than the boxes'
/// margin.
/// @param from  what they are to be relative to
TriangleRow row_of(std::span<const TrianglePoints> triangles, const Eigen::Vector3d& from);

/// Fits a box around the triangles and stores it as box k: its axes as fitted_axes() has them, or the frame's own where
/// such a box has less area and is not thicker. Conservative: the box as the box test will read it holds every point of
/// the triangles.
/// @param bounds  a box along the frame's axes that is nearly the triangles'
void fit_box(BoxNode& node, unsigned k, const TriangleColumns& triangles, const Aabb& bounds);
/// Stores a box along the frame's axes as box k.
void set_box(BoxNode& node, unsigned k, const Aabb& box);

} // namespace oncollide
