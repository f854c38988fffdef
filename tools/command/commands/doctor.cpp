#include "cli/arguments.hpp"
#include "cli/build_info.hpp"
#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/outputs.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"
#include "common/zip_bytes.hpp"
#include "convert/converters.hpp"
#include "render/graphics_process.hpp"
#include "view/three_js.hpp"

#if defined(ONCOLLIDE_HDF5_LIBRARY) || defined(ONCOLLIDE_GDAL_LIBRARY)
#include <dlfcn.h>
#endif

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <sstream>

#include <Eigen/Core>
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>

namespace oncollide::tools {
namespace {

/// The findings, one line per topic, for the terminal and for a report.
class Findings {
public:
    void say(std::string_view topic, const std::string& what)
    {
        text_ += fmt::format("{:<14}{}\n", topic, printable(what));
    }
    const std::string& text() const { return text_; }

private:
    std::string text_;
};

std::string data(const std::string& option)
{
    try {
        const std::filesystem::path folder = data_folder(option);
        if (folder.empty()) return "none; scenes use generated stand-ins (set ONCOLLIDE_DATA or give --data)";
        std::string missing;
        for (const char* part : {"meshes", "octomap"})
            if (!is_folder(folder / part)) missing += fmt::format(", without {}/", part);
        return folder.string() + missing;
    } catch (const Error& error) {
        return error.what();
    }
}

/// Runs one pair of boxes that overlap and two boxes that do not through the whole pipeline. "" if the results are
/// right.
std::string self_test(std::string& backend)
{
    try {
        Scene scene;
        const GeometryId box = scene.add("box", Box{{0.5, 0.5, 0.5}});
        for (double x : {0.0, 0.9, 5.0}) {
            BodyInit body{.name = fmt::format("box at {}", x), .geometry = box};
            body.pose.translation().x() = x;
            scene.add_body(body);
        }
        Settings settings;
        if (fcl_available()) settings.exact = ExactLevel::fcl;
        Pipeline pipeline(scene, settings);
        backend = pipeline.inspect().backend;
        int colliding = 0;
        for (const PairResult& pair : pipeline.step(scene).pairs) colliding += pair.verdict == Verdict::colliding;
        return colliding == 1 ? "" : fmt::format("found {} colliding pairs; expected 1", colliding);
    } catch (const Error& error) {
        return error.what();
    }
}

/// @param version  empty: the build has no such library
std::string_view version_or_none(std::string_view version)
{
    return version.empty() ? "none" : version;
}

#if defined(ONCOLLIDE_HDF5_LIBRARY) || defined(ONCOLLIDE_GDAL_LIBRARY)
/// The version of a library that is loaded when a file first needs it.
template <class Version>
std::string loaded_library(const char* what, const char* file, Version version)
{
    void* const library = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
    return library ? fmt::format("{} {}", what, version(library))
                   : fmt::format("{}: this build can use {}, which is not installed", what, file);
}
#endif

/// Libraries that are optional at build time and at run time.
void say_loaded_libraries([[maybe_unused]] Findings& found)
{
#ifdef ONCOLLIDE_HDF5_LIBRARY
    found.say("HDF5 files", loaded_library("HDF5", ONCOLLIDE_HDF5_LIBRARY, [](void* library) {
                  unsigned version[3]{};
                  using Get = int (*)(unsigned*, unsigned*, unsigned*);
                  if (const auto get = reinterpret_cast<Get>(::dlsym(library, "H5get_libversion")))
                      get(&version[0], &version[1], &version[2]);
                  return fmt::format("{}.{}.{}", version[0], version[1], version[2]);
              }));
#else
    found.say("HDF5 files", "left out of this build (ONCOLLIDE_HDF5=OFF)");
#endif
#ifdef ONCOLLIDE_GDAL_LIBRARY
    found.say("GeoTIFF files", loaded_library("GDAL", ONCOLLIDE_GDAL_LIBRARY, [](void* library) {
                  using Get = const char* (*)(const char*);
                  const auto get = reinterpret_cast<Get>(::dlsym(library, "GDALVersionInfo"));
                  return std::string(get ? get("RELEASE_NAME") : "of an unknown version");
              }));
#else
    found.say("GeoTIFF files", "left out of this build (ONCOLLIDE_GDAL=OFF)");
#endif
}

/// Reports the libraries that pages, archives and tables of other programs need.
void say_files(Findings& found)
{
    try {
        found.say("pages in 3D", "three.js in " + read_three_js().folder);
    } catch (const Error& missing) {
        found.say("pages in 3D", missing.what());
    }
    const std::string zip = zip_version();
    found.say("zip files", zip.empty() ? "left out of this build (ONCOLLIDE_XML=OFF): no BCF, 3MF, COLLADA, URDF, MJCF"
                                       : "libzip " + zip);
#ifdef ONCOLLIDE_YAML_VERSION
    found.say("YAML files", "yaml-cpp " ONCOLLIDE_YAML_VERSION);
#else
    found.say("YAML files", "left out of this build (it needs yaml-cpp; Debian: libyaml-cpp-dev)");
#endif
    say_loaded_libraries(found);
    for (const auto& [converter, what] : describe_converters()) found.say(converter, what);
}

/// The platforms of all devices, one per line.
std::string gpu_platforms()
{
    std::string lines;
    for (const GpuDevice& device : gpu_devices()) lines += device.platform + "\n";
    return lines;
}

std::string gpu_text(int number)
{
    const GpuInfo info = describe_gpu(number);
    return fmt::format("{}{}; OpenGL {}; context in {:.0f} ms", info.renderer,
                       info.software ? " (software: slower than --backend cpu)" : "", info.version, info.start_ms);
}

/// Opens every device: only an open device reports its renderer. Each device is opened in a process of its own, so that
/// a driver that crashes is a finding.
void say_gpus(Findings& found)
{
    try {
        std::istringstream platforms(GraphicsProcess([](std::string_view) { return gpu_platforms(); }).request({}));
        int number = 0;
        for (std::string platform; std::getline(platforms, platform); ++number) {
            std::string what;
            try {
                what = GraphicsProcess([number](std::string_view) { return gpu_text(number); }).request({});
            } catch (const Error& error) {
                what = fmt::format("cannot be used: {}", error.what());
            }
            found.say(fmt::format("GPU {}", number), fmt::format("{}: {}", platform, what));
        }
    } catch (const Error& error) {
        found.say("GPU", error.what());
    }
}

/// Further lines for a bug report. These lines list only the variables of the environment that affect the program.
void say_surroundings(Findings& found)
{
    found.say("flags", build_flags());
    found.say("system", system_name());
    found.say("memory", fmt::format("{:.1f} GB", double(system_memory()) / 1e9));
    for (const char* name : {"ONCOLLIDE_DATA", "ONCOLLIDE_ISA", "ONCOLLIDE_LOG", "OMP_NUM_THREADS", "OMP_WAIT_POLICY",
                             "EGL_PLATFORM", "__EGL_VENDOR_LIBRARY_FILENAMES", "LIBGL_ALWAYS_SOFTWARE",
                             "MESA_LOADER_DRIVER_OVERRIDE", "LD_LIBRARY_PATH", "LD_PRELOAD", "LANG", "LC_ALL"})
        if (const char* const value = std::getenv(name)) found.say("environment", fmt::format("{}={}", name, value));
}

struct DoctorOptions {
    std::string data, report;
};

int doctor(const DoctorOptions& options, std::string (*peers)())
{
    check_files({{"--report", options.report}});
    std::string backend = "none";
    const std::string fault = self_test(backend);
    Findings found;
    const auto say = [&](std::string_view topic, const std::string& what) { found.say(topic, what); };
    say("oncollide", std::string(version));
    say("build", build_text());
    say("parts", parts_text());
    say("processor", processor_name());
    say("instructions", fmt::format("{}; backend: {}", instruction_sets_text(), backend));
    say_gpus(found);
    say("backends",
        has_gpu_backends()
            ? "cpu, gl, gl-compute: certified; gl-query, the paper's method: not certified, for comparison only"
            : "cpu: certified");
    say("threads", fmt::format("{} usable", hardware_threads()));
    say("data", data(options.data));
    const std::string expat = *ONCOLLIDE_EXPAT_VERSION ? ", Expat " ONCOLLIDE_EXPAT_VERSION : "";
    say("libraries",
        fmt::format("Eigen {}.{}.{}, FCL {}, OctoMap {}, Qhull {}, fmt {}.{}.{}, JSON {}, CLI11 {}, libpng {}{}",
                    EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                    version_or_none(ONCOLLIDE_FCL_VERSION), version_or_none(ONCOLLIDE_OCTOMAP_VERSION),
                    ONCOLLIDE_QHULL_VERSION, FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100,
                    ONCOLLIDE_JSON_VERSION, ONCOLLIDE_CLI11_VERSION, version_or_none(ONCOLLIDE_PNG_VERSION), expat));
    say_files(found);
    if (peers) say("peers", peers());
    say("self-test", fault.empty() ? "passed" : "FAILED: " + fault);
    write_to_stdout(found.text());
    if (!options.report.empty()) {
        say_surroundings(found);
        OutputFile file(options.report);
        file.write(found.text());
        file.commit();
        if (options.report != "-")
            write_to_stdout(fmt::format(
                "\nWritten to {}. Check its contents, then attach it to your bug report together with the command "
                "and its output.\n",
                printable(options.report)));
    }
    return fault.empty() ? 0 : int(ErrorKind::internal);
}

} // namespace

void add_doctor(Arguments app, std::string (*peers)())
{
    Arguments sub = app.add_command("doctor", "List the capabilities of this machine and this build");
    auto options = std::make_shared<DoctorOptions>();
    sub.add_option("--data DIR", options->data, "data folder to check");
    sub.add_option(
        "--report FILE", options->report,
        "also write the findings, the system and the relevant environment variables to a file, for a bug report");
    sub.action([options, peers] { return doctor(*options, peers); });
}

} // namespace oncollide::tools
