#pragma once
#include <span>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/obb/fits/box_fit_kernel.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const OrientedBoxKernel& oriented_box_kernel()
{
    static const OrientedBoxKernel kernel = ONCOLLIDE_CHOOSE(oriented_box_kernel);
    return kernel;
}

/// Sets the node's frame so that the coordinates of boxes around parts of the sphere fit.
void set_frame(BoxNode& node, const Eigen::Vector3d& centre, double radius);

/// The centre of box k, and an upper bound of the distance of its points from it.
Eigen::Vector3d centre_of(const BoxNode& node, unsigned k);
double radius_of(const BoxNode& node, unsigned k);
/// True if a point of the tree's frame is in box k, as quantise() stores it.
bool holds(const BoxNode& node, unsigned k, const Eigen::Vector3d& point);

/// Packs at most eight triangles for the kernel. The boxes that the kernel makes of them hold their corners, with an
/// error below the boxes' margin.
/// @param from  origin of the packed coordinates
TriangleRow row_of(std::span<const TrianglePoints> triangles, const Eigen::Vector3d& from);

/// The node's frame, for fits.
StoredFrame frame_of(const BoxNode& node);
/// Sets the node's boxes.
void set_boxes(BoxNode& node, const StoredBoxes& boxes);
/// Stores a box along the frame's axes as box k.
void set_box(BoxNode& node, unsigned k, const Aabb& box);

} // namespace oncollide
