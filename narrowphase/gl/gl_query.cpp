#include <oncollide/narrowphase/gpu.hpp>

namespace oncollide {

std::unique_ptr<OcclusionBackend> make_gl_query_backend(const GlQueryOptions&)
{
    throw GpuLost("gl-query: not built yet");
}

} // namespace oncollide
