#include <oncollide/narrowphase/gl/context.hpp>

#include <array>
#include <chrono>
#include <cstdlib>
#include <dlfcn.h>
#include <string_view>

#include <fmt/format.h>

namespace oncollide {

namespace {

[[noreturn]] void fail(const std::string& message)
{
    throw Error(ErrorKind::no_gpu, message);
}

/// epoxy ends the program if a library is missing, so look for them first. A download brings its own in case the system
/// has none (cmake/packaging/launcher.sh); epoxy then finds them by name, as they are loaded.
void need_libraries()
{
    const auto loads = [](const std::string& file) {
        return ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL) != nullptr;
    };
    const char* const own = std::getenv("ONCOLLIDE_GL_LIBRARIES");
    struct Needed {
        const char *library, *other, *package;
    };
    for (const Needed& n :
         {Needed{"libEGL.so.1", nullptr, "libegl1"}, Needed{"libOpenGL.so.0", "libGL.so.1", "libopengl0"}})
        if (!loads(n.library) && !(n.other && loads(n.other)) && !(own && loads(fmt::format("{}/{}", own, n.library))))
            fail(fmt::format("no GPU: {} is missing (Debian: install {} and libgl1-mesa-dri)", n.library, n.package));
}

bool has(const char* extensions, const char* wanted)
{
    return extensions && epoxy_extension_in_string(extensions, wanted);
}

std::string egl_error()
{
    return fmt::format("EGL error 0x{:x}", static_cast<unsigned>(eglGetError()));
}

/// A device by its EGL handle; null: the surfaceless platform.
struct Candidate {
    GpuDevice device;
    EGLDeviceEXT handle = nullptr;
};

std::vector<Candidate> candidates()
{
    need_libraries();
    std::vector<Candidate> found;
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (has(client, "EGL_EXT_device_enumeration") || has(client, "EGL_EXT_device_base")) {
        std::array<EGLDeviceEXT, 64> handles{};
        EGLint count = 0;
        if (has(client, "EGL_EXT_platform_device") &&
            eglQueryDevicesEXT(EGLint(handles.size()), handles.data(), &count))
            for (EGLint i = 0; i < count; ++i) {
                const char* own = eglQueryDeviceStringEXT(handles[std::size_t(i)], EGL_EXTENSIONS);
                const bool software = has(own, "EGL_MESA_device_software");
                const char* node = has(own, "EGL_EXT_device_drm")
                                       ? eglQueryDeviceStringEXT(handles[std::size_t(i)], EGL_DRM_DEVICE_FILE_EXT)
                                       : nullptr;
                found.push_back({{fmt::format("EGL device{}", node       ? fmt::format(" {}", node)
                                                              : software ? " (software)"
                                                                         : ""),
                                  software},
                                 handles[std::size_t(i)]});
            }
    }
    if (has(client, "EGL_MESA_platform_surfaceless")) found.push_back({{"EGL surfaceless", false}, nullptr});
    if (found.empty())
        fail("no GPU: EGL offers neither devices nor the surfaceless platform; is a driver installed (Debian: "
             "libgl1-mesa-dri)?");
    return found;
}

/// Hardware devices first, then software, then surfaceless, which may be either.
std::size_t best_of(const std::vector<Candidate>& all)
{
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].handle && !all[i].device.software) return i;
    return 0;
}

} // namespace

std::vector<GpuDevice> gpu_devices()
{
    std::vector<GpuDevice> devices;
    for (Candidate& candidate : candidates()) devices.push_back(std::move(candidate.device));
    return devices;
}

GpuInfo describe_gpu(int gpu)
{
    return gl::Context(gpu).info();
}

std::vector<std::pair<std::string, std::int64_t>> gpu_limits(int gpu)
{
    const gl::Context context(gpu);
    std::vector<std::pair<std::string, std::int64_t>> limits;
    for (const auto& [name, what] :
         {std::pair{"GL_MAX_SHADER_STORAGE_BLOCK_SIZE", GL_MAX_SHADER_STORAGE_BLOCK_SIZE},
          std::pair{"GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS", GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS},
          std::pair{"GL_MAX_COMPUTE_SHARED_MEMORY_SIZE", GL_MAX_COMPUTE_SHARED_MEMORY_SIZE},
          std::pair{"GL_MAX_RENDERBUFFER_SIZE", GL_MAX_RENDERBUFFER_SIZE},
          std::pair{"GL_SUBPIXEL_BITS", GL_SUBPIXEL_BITS}}) {
        GLint64 value = 0;
        glGetInteger64v(static_cast<GLenum>(what), &value);
        limits.emplace_back(name, value);
    }
    for (const auto& [name, target] :
         {std::pair{"bits of GL_SAMPLES_PASSED", GL_SAMPLES_PASSED}, std::pair{"bits of GL_TIMESTAMP", GL_TIMESTAMP}}) {
        GLint bits = 0;
        glGetQueryiv(static_cast<GLenum>(target), GL_QUERY_COUNTER_BITS, &bits);
        limits.emplace_back(name, bits);
    }
    context.check("reading limits");
    return limits;
}

namespace gl {

namespace {

/// EGL has one display per device in a process. It stays open: a driver takes tens of milliseconds to load, and Mesa's
/// leaks memory when it is unloaded.
EGLDisplay open_display(const Candidate& candidate)
{
    const EGLDisplay display =
        candidate.handle ? eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, candidate.handle, nullptr)
                         : eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY) fail(fmt::format("{}: no display ({})", candidate.device.platform, egl_error()));
    if (!eglInitialize(display, nullptr, nullptr)) // no effect if it is already initialised
        fail(fmt::format("{}: cannot be initialised ({}); is a driver installed (Debian: libgl1-mesa-dri)?",
                         candidate.device.platform, egl_error()));
    return display;
}

EGLContext create(EGLDisplay display, const std::string& platform, bool& robust)
{
    const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
    if (!has(extensions, "EGL_KHR_surfaceless_context"))
        fail(platform + ": cannot make a context without a surface (no EGL_KHR_surfaceless_context)");
    if (!eglBindAPI(EGL_OPENGL_API)) fail(fmt::format("{}: offers no OpenGL ({})", platform, egl_error()));
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!has(extensions, "EGL_KHR_no_config_context")) {
        const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(display, wanted, &config, 1, &count) || count < 1)
            fail(fmt::format("{}: no configuration for OpenGL ({})", platform, egl_error()));
    }
    for (const EGLint minor : {5, 3})
        for (const bool with_reset : {true, false}) {
            const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                         4,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         minor,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         with_reset ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY : EGL_NONE,
                                         EGL_LOSE_CONTEXT_ON_RESET,
                                         EGL_NONE};
            const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
            robust = with_reset;
            if (context != EGL_NO_CONTEXT) return context;
        }
    fail(fmt::format("{}: no OpenGL 4.3 core context ({})", platform, egl_error()));
}

/// Parts of OpenGL 4.4 and 4.5 that the code uses; most drivers of 4.3 have them.
void need_extensions(const std::string& platform)
{
    if (epoxy_gl_version() >= 45) return;
    for (const char* name : {"GL_ARB_buffer_storage", "GL_ARB_direct_state_access"})
        if (!epoxy_has_gl_extension(name))
            fail(fmt::format("{}: OpenGL {}.{} without {}", platform, epoxy_gl_version() / 10, epoxy_gl_version() % 10,
                             name));
}

std::string text(GLenum name)
{
    const auto* value = reinterpret_cast<const char*>(glGetString(name));
    return value ? value : "unknown";
}

bool is_software(std::string_view renderer)
{
    for (const char* name : {"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer"})
        if (renderer.find(name) != std::string_view::npos) return true;
    return false;
}

} // namespace

Context::Context(int gpu)
{
    const auto from = std::chrono::steady_clock::now();
    const std::vector<Candidate> all = candidates();
    if (gpu >= int(all.size()) || gpu < -1)
        fail(fmt::format("no GPU {}: this machine has 0 to {} ('oncollide doctor' lists them)", gpu, all.size() - 1));
    const Candidate& chosen = all[gpu < 0 ? best_of(all) : std::size_t(gpu)];
    display_ = open_display(chosen);
    context_ = create(display_, chosen.device.platform, robust_);
    use();
    need_extensions(chosen.device.platform);
    info_.renderer = text(GL_RENDERER), info_.vendor = text(GL_VENDOR), info_.version = text(GL_VERSION);
    info_.platform = chosen.device.platform;
    if (epoxy_gl_version() < 45 && !epoxy_has_gl_extension("GL_KHR_robustness")) robust_ = false; // no status of resets
    info_.software = is_software(info_.renderer);
    info_.start_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
}

Context::~Context()
{
    if (eglGetCurrentContext() == context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
}

void Context::use() const
{
    if (std::this_thread::get_id() != owner_)
        throw Error(ErrorKind::usage, "a GPU backend is used by another thread than the one that made it");
    if (eglGetCurrentContext() == context_) return;
    if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
        throw GpuLost(fmt::format("{}: the context cannot be used ({})", info_.platform, egl_error()));
}

void Context::use_at_end() const noexcept
{
    if (eglGetCurrentContext() != context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
}

void Context::check(const char* what) const
{
    if (robust_)
        if (const GLenum reset = glGetGraphicsResetStatus(); reset != GL_NO_ERROR)
            throw GpuLost(fmt::format("{}: the GPU was reset during {} (status 0x{:x})", info_.renderer, what, reset));
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
        throw GpuLost(error == GL_OUT_OF_MEMORY
                          ? fmt::format("{}: out of GPU memory during {}", info_.renderer, what)
                          : fmt::format("{}: {} failed (OpenGL error 0x{:x})", info_.renderer, what, error));
}

} // namespace gl
} // namespace oncollide
