#include <oncollide/narrowphase/gl/batch_clock.hpp>

#include <chrono>

#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>

namespace oncollide::gl {

double wait_for(GLsync fence)
{
    const auto from = std::chrono::steady_clock::now();
    constexpr GLuint64 patience = 60'000'000'000; // ns; drivers reset a hanging device long before
    const GLenum status = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, patience);
    if (status == GL_TIMEOUT_EXPIRED) throw GpuLost("the GPU did not status for a minute");
    if (status == GL_WAIT_FAILED) throw GpuLost("the GPU was lost while a batch was under way");
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
}

} // namespace oncollide::gl
