#pragma once
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/assembly/part_placer.hpp>
#include <oncollide/scenes/files/threemf/zip_archive.hpp>

namespace oncollide {

// A 3MF file holds one or more models: XML files, which may refer to objects of each other. Private to scenes.

/// An object of a model, placed by the build or by another object.
struct ModelReference {
    std::string model; ///< its file; empty: the file of the reference
    std::uint32_t object;
    Eigen::Affine3d pose;
    std::size_t line;
};

struct ModelObject {
    std::string name;
    std::size_t line = 0;
    RawMesh mesh{};
    std::vector<ModelReference> components{};
};

struct ModelPart {
    double metres = 1e-3; ///< metres per unit
    std::map<std::uint32_t, ModelObject> objects;
    std::vector<ModelReference> build;
};

/// Throws Error{bad_data} naming the line; the triangles' indices are in range.
/// @param expansion counts each vertex, triangle and component
ModelPart read_model_part(const MeshSource& source, const ZipArchive& archive, const std::string& file,
                          ExpansionLimit& expansion);

} // namespace oncollide
