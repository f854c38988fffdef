#pragma once
#include <Eigen/Geometry>

#include <oncollide/scenes/files/xml/xml_element.hpp>

namespace oncollide {

/// The pose of a node relative to its parent: the product of its transforms. Private to scenes.
Eigen::Affine3d collada_pose(const MeshSource& source, const XmlElement& node);

/// The element's 16 numbers, row by row.
Eigen::Affine3d collada_matrix(const MeshSource& source, const XmlElement& element);

/// From the file's units and axes to metres, with z up.
Eigen::Affine3d collada_units(const MeshSource& source, const XmlElement& root);

} // namespace oncollide
