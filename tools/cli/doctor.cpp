#include "cli/arguments.hpp"
#include "cli/command.hpp"
#include "cli/options.hpp"
#include "cli/system.hpp"

#include <cstdlib>
#include <iostream>
#include <memory>

#include <Eigen/Core>
#include <fmt/format.h>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/base/printable.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>

namespace oncollide::tools {
namespace {

void say(std::string_view topic, const std::string& text)
{
    std::cout << fmt::format("{:<14}{}\n", topic, printable(text));
}

std::string instruction_sets()
{
    std::string sets;
    for (const InstructionSet set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512})
        if (set <= best_instruction_set()) sets += fmt::format("{}{}", sets.empty() ? "" : ", ", name_of(set));
    return sets;
}

std::string data(const std::string& option)
{
    try {
        const std::filesystem::path folder = data_folder(option);
        if (folder.empty()) return "none; scenes use generated stand-ins (set ONCOLLIDE_DATA or give --data)";
        std::string missing;
        for (const char* part : {"meshes", "octomap"})
            if (!std::filesystem::is_directory(folder / part)) missing += fmt::format(", without {}/", part);
        return folder.string() + missing;
    } catch (const Error& error) {
        return error.what();
    }
}

/// Two boxes that overlap and two that do not, through the whole pipeline: "" when the answers are right.
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
        settings.exact = ExactLevel::fcl;
        Pipeline pipeline(scene, settings);
        backend = pipeline.backend();
        int colliding = 0;
        for (const PairResult& pair : pipeline.step(scene).pairs) colliding += pair.verdict == Verdict::colliding;
        return colliding == 1 ? "" : fmt::format("found {} colliding pairs where there is 1", colliding);
    } catch (const Error& error) {
        return error.what();
    }
}

/// Every device is opened: which renderer answers shows only then.
void say_gpus()
{
    try {
        const std::vector<GpuDevice> devices = gpu_devices();
        for (std::size_t i = 0; i < devices.size(); ++i) {
            std::string answer;
            try {
                const GpuInfo info = describe_gpu(int(i));
                answer = fmt::format("{}{}; OpenGL {}; context in {:.0f} ms", info.renderer,
                                     info.software ? " (software: slower than --backend cpu)" : "", info.version,
                                     info.start_ms);
            } catch (const Error& error) {
                answer = fmt::format("cannot be used: {}", error.what());
            }
            say(fmt::format("GPU {}", i), fmt::format("{}: {}", devices[i].platform, answer));
        }
    } catch (const Error& error) {
        say("GPU", error.what());
    }
}

int doctor(const std::string& data_option)
{
    std::string backend = "none";
    const std::string fault = self_test(backend);
    say("oncollide", std::string(version));
    say("processor", processor_name());
    say("instructions", fmt::format("{}; in use: {}", instruction_sets(), backend));
    say_gpus();
    say("threads", fmt::format("{} usable", hardware_threads()));
    say("data", data(data_option));
    say("libraries",
        fmt::format("Eigen {}.{}.{}, FCL {}, OctoMap {}, Qhull {}, fmt {}.{}.{}, JSON {}, CLI11 {}",
                    EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, ONCOLLIDE_FCL_VERSION,
                    ONCOLLIDE_OCTOMAP_VERSION, ONCOLLIDE_QHULL_VERSION, FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                    FMT_VERSION % 100, ONCOLLIDE_JSON_VERSION, ONCOLLIDE_CLI11_VERSION));
    say("compiler", __VERSION__);
    say("self-test", fault.empty() ? "passed" : "FAILED: " + fault);
    return fault.empty() ? 0 : int(ErrorKind::internal);
}

} // namespace

void add_doctor(Arguments app)
{
    Arguments sub = app.add_command("doctor", "Say what this machine and this build offer; writes nothing");
    auto option = std::make_shared<std::string>();
    sub.add_option("--data", *option, "folder to look for data in").type_name("DIR");
    sub.action([option] { return doctor(*option); });
}

} // namespace oncollide::tools
