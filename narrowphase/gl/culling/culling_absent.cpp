// Replaces the other sources of this folder in builds without OpenGL.
#include <oncollide/narrowphase/gl/culling/pair_culling.hpp>

#include <oncollide/narrowphase/gl/gpu.hpp>

namespace oncollide {

std::unique_ptr<PairCulling> make_cullide(const CullideOptions& options)
{
    describe_gpu(options.gpu); // throws
    return nullptr;
}

std::unique_ptr<PairCulling> make_viewing_volumes(const ViewingVolumesOptions& options)
{
    describe_gpu(options.gpu); // throws
    return nullptr;
}

} // namespace oncollide
