#include <oncollide/narrowphase/gpu.hpp>

namespace oncollide {

std::unique_ptr<OcclusionBackend> make_gl_compute_backend(const GlComputeOptions&)
{
    throw GpuLost("gl-compute: not built yet");
}

} // namespace oncollide
