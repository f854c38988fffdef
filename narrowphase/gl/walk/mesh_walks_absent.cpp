// Replaces the other sources of this folder in builds without OpenGL.
#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

namespace oncollide {

std::unique_ptr<MeshWalks> make_mesh_walks(const MeshWalkOptions&)
{
    throw Error(ErrorKind::no_gpu, "this is a build without OpenGL (ONCOLLIDE_GL=OFF)");
}

} // namespace oncollide
