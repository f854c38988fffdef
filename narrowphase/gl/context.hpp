#pragma once
#include <string>
#include <thread>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <oncollide/narrowphase/gl/gpu.hpp>

namespace oncollide::gl {

/// An OpenGL core context without a display or a window: 4.5, or 4.3 with the extensions for buffers that are mapped
/// while in use and for objects that are changed without binding them. Belongs to the thread that made it.
class Context {
public:
    /// @param gpu  the device, as for describe_gpu()
    explicit Context(int gpu);
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    /// Makes it the thread's current context: each entry into GL code calls this first. Throws Error{usage} on another
    /// thread.
    void use() const;
    /// The same without exceptions, for destructors of objects in the context. Objects of a lost GPU are lost with it.
    void use_at_end() const noexcept;
    /// Throws GpuLost if the device was lost or a command since the last check failed; `what` names the work.
    void check(const char* what) const;
    const GpuInfo& info() const { return info_; }

private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    std::thread::id owner_ = std::this_thread::get_id();
    bool robust_ = false;
    GpuInfo info_;
};

} // namespace oncollide::gl
