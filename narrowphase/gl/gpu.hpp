#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>

namespace oncollide {

/// A device on which an OpenGL context without a display can be made. Its number is its index in gpu_devices().
struct GpuDevice {
    std::string platform; ///< "EGL device (EGL_MESA_device_software)", "EGL surfaceless"
    bool software;        ///< known to be a software renderer before it is opened
};

/// The devices of this machine, in EGL's order, without opening any. Cost: loads EGL, about 10 ms the first time.
/// Throws Error{no_gpu}, which names the missing library or extension.
std::vector<GpuDevice> gpu_devices();

/// Properties of an opened device.
struct GpuInfo {
    std::string renderer, vendor, version; ///< GL_RENDERER, GL_VENDOR, GL_VERSION
    std::string platform;
    bool software;   ///< a software renderer such as llvmpipe
    double start_ms; ///< time to make the context
};

/// Opens device number `gpu` and closes it again; -1: the first hardware device, else the first software device. Throws
/// Error{no_gpu}, which names the failed step.
GpuInfo describe_gpu(int gpu);

/// Limits of an opened device that bound batches and pictures, by OpenGL's names. Arguments and errors as
/// describe_gpu().
std::vector<std::pair<std::string, std::int64_t>> gpu_limits(int gpu);

/// Separating axes in a compute shader: the results of the cpu backend, bit for bit. Triangle lists stay on the GPU.
/// The backend belongs to the thread that made it.
struct GlComputeOptions {
    int gpu = -1;
    /// Upper limit of the size of one buffer (bytes); 0: the driver's limit, at most 2 GiB. A mesh that does not fit is
    /// left to the cpu backend; triangle lists that do not fit cause GpuLost.
    std::size_t most_buffer_bytes = 0;
    std::size_t first_entries = 1 << 16; ///< initial room for list entries; it grows
};
std::unique_ptr<OcclusionBackend> make_gl_compute_backend(const GlComputeOptions& options = {});

/// The method of the paper, for reference: tests whether a fragment is drawn with the cell as view volume. Not
/// conservative: triangles seen edge-on or smaller than a pixel leave no fragment. error() allows for grey octants
/// without surface; nothing allows for missed octants. Source: Franquesa-Niubó and Rodríguez González, GRAPP 2006,
/// section 4.
struct GlQueryOptions {
    enum class Primitives : unsigned char { soup, indexed, strips };
    enum class Samples : unsigned char { passed, any };
    enum class Draw : unsigned char { mesh, inherited }; ///< the whole mesh, or the triangles whose boxes meet the cell
    int gpu = -1;
    int viewport = 16; ///< pixels per side, 1 to 1024
    Primitives primitives = Primitives::indexed;
    Samples samples = Samples::any;
    Draw draw = Draw::inherited; ///< strips always draw the whole mesh
    bool inflated = false;       ///< the view volume is half a texel larger on every side
};
std::unique_ptr<OcclusionBackend> make_gl_query_backend(const GlQueryOptions& options = {});

} // namespace oncollide
