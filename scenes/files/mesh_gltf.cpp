#include <Eigen/LU>
#include <assimp/Importer.hpp>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <oncollide/scenes/files/gltf_check.hpp>
#include <oncollide/scenes/files/mesh_source.hpp>

namespace oncollide {

namespace {

std::string first_line(const std::string& text)
{
    return text.substr(0, text.find('\n'));
}

void add_part(const MeshSource& source, const aiMesh& part, const aiMatrix4x4& pose, RawMesh& mesh)
{
    const std::size_t first = mesh.vertices.size();
    Eigen::Matrix<double, 3, 4> to_file;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) to_file(i, j) = static_cast<double>(pose[i][j]);
    const bool mirrored = to_file.leftCols<3>().determinant() < 0;
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& p = part.mVertices[i];
        mesh.vertices.push_back(to_file * Eigen::Vector4d(p.x, p.y, p.z, 1));
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        const aiFace& face = part.mFaces[i];
        if (face.mNumIndices != 3) continue; // points and lines
        Triangle t;
        for (int k = 0; k < 3; ++k) {
            if (face.mIndices[k] >= part.mNumVertices)
                source.fail(fmt::format("triangle {} of mesh '{}' uses vertex {}, but it has {} vertices", i,
                                        part.mName.C_Str(), face.mIndices[k], part.mNumVertices));
            t[k] = static_cast<std::uint32_t>(first + face.mIndices[k]);
        }
        if (mirrored) std::swap(t[1], t[2]); // keeps the front at the front, as the format requires
        mesh.triangles.push_back(t);
    }
}

void add_node(const MeshSource& source, const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
              RawMesh& mesh)
{
    const aiMatrix4x4 pose = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add_part(source, *scene.mMeshes[node.mMeshes[i]], pose, mesh);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(source, scene, *node.mChildren[i], pose, mesh);
}

} // namespace

RawMesh read_gltf(const MeshSource& source)
{
    const std::size_t announced = check_gltf(source);
    // Assimp has no logger by default. No post-processing: it would drop, merge or move triangles.
    RawMesh mesh;
    try {
        Assimp::Importer importer;
        const aiScene* scene = importer.ReadFile(source.name, 0);
        if (scene == nullptr)
            source.fail(fmt::format("not a valid glTF file: {}", first_line(importer.GetErrorString())));
        if (scene->mRootNode != nullptr) add_node(source, *scene, *scene->mRootNode, aiMatrix4x4(), mesh);
    } catch (const std::bad_alloc&) {
        source.fail("not a valid glTF file: it needs more memory than there is");
    }
    if (mesh.triangles.size() != announced)
        source.fail(fmt::format("damaged: of {} triangles only {} have valid vertex numbers", announced,
                                mesh.triangles.size()));
    return mesh;
}

} // namespace oncollide
