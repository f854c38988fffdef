// oncollide accuracy fuzz: small random scenes, checked against the truth and against each other.
#include "cli/command.hpp"

#include <iostream>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "verify/trials/differential.hpp"

namespace oncollide::tools {
namespace {

struct FuzzOptions {
    std::int64_t scenes = 10'000;
    std::uint64_t seed = 1;
    int threads = 1;
    std::string out = "fault.json";
};

int fuzz(const FuzzOptions& options)
{
    check_range("--scenes", options.scenes, 1);
    check_range("--threads", options.threads, 0, 1024);
    check_files({{"--out", options.out}});
    Progress progress("scenes", std::size_t(options.scenes));
    const int threads = options.threads ? options.threads : hardware_threads();
    const auto first =
        first_faulty_seed(options.seed, std::uint64_t(options.scenes), threads, [&] { progress.step(); });
    if (!first) {
        std::cout << fmt::format("{} scenes, seeds {} to {}: no fault\n", options.scenes, options.seed,
                                 options.seed + std::uint64_t(options.scenes) - 1);
        return 0;
    }
    const DrawnScene drawn = draw_scene(*first),
                     small = shrunk(drawn, [](const DrawnScene&d) { return !fault_in(d).empty(); });
    save_scene(small.scene, options.out);
    std::cout << fmt::format("seed {}: {}\nreduced to {} bodies: {}\noncollide run {} {}\n", *first, fault_in(drawn),
                             small.scene.size(), fault_in(small), options.out, options_of(small.settings));
    return int(ErrorKind::internal);
}

} // namespace

void add_accuracy_fuzz(Arguments accuracy)
{
    Arguments sub = accuracy.add_command("fuzz", "Check small random scenes against the truth and against each other");
    auto options = std::make_shared<FuzzOptions>();
    sub.add_option("--scenes N", options->scenes, "number of scenes (default 10000)");
    sub.add_option("--seed S", options->seed, "seed of the first scene; each scene has the next number (default 1)");
    sub.add_option("--threads N", options->threads, "number of threads; 0: all (default 1)");
    sub.add_option("--out FILE", options->out, "file for the smallest faulty scene (default fault.json)");
    sub.footer("Scenes of two to four meshes, shapes, maps and terrains, with all settings. Most are on a grid of 1/8, "
               "where touching is common. The truth comes from extended precision and shares no code with the library. "
               "Exit code 70: a fault was found; the scene is reduced to a small scene file, and the options are "
               "printed.");
    sub.action([options] { return fuzz(*options); });
}

} // namespace oncollide::tools
