// Replaces the other sources of this folder in builds without OpenGL.
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/narrowphase/gl/picture.hpp>

namespace oncollide {
namespace {

[[noreturn]] void refuse()
{
    throw Error(ErrorKind::no_gpu, "this is a build without OpenGL (ONCOLLIDE_GL=OFF)");
}

} // namespace

std::vector<GpuDevice> gpu_devices()
{
    refuse();
}

GpuInfo describe_gpu(int)
{
    refuse();
}

std::vector<std::pair<std::string, std::int64_t>> gpu_limits(int)
{
    refuse();
}

std::unique_ptr<OcclusionBackend> make_gl_compute_backend(const GlComputeOptions&)
{
    refuse();
}

std::unique_ptr<OcclusionBackend> make_gl_query_backend(const GlQueryOptions&)
{
    refuse();
}

struct Painter::Tools {};

Painter::Painter(int)
{
    refuse();
}

Painter::~Painter() = default;

std::vector<std::uint8_t> Painter::draw(const Picture&)
{
    refuse();
}

} // namespace oncollide
