// Stands for mesh_gltf.cpp in builds without Assimp.
#include <oncollide/scenes/files/mesh_source.hpp>

namespace oncollide {

RawMesh read_gltf(const MeshSource& source)
{
    source.fail("this is a build that cannot read glTF (ONCOLLIDE_ASSIMP=OFF)");
}

} // namespace oncollide
