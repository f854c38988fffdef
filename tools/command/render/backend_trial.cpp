#include "render/backend_trial.hpp"

#include <map>
#include <string>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/pipeline/world.hpp>

#include "cli/log.hpp"
#include "cli/system.hpp"
#include "render/graphics_process.hpp"

namespace oncollide::tools {
namespace {

/// Plays two crossing pyramids, whose trees grow through all of the driver. Returns why `auto` or `gl`
/// chose the CPU; empty: it did not.
std::string play_two_bodies(const Settings& like)
{
    World world({.backend = like.backend, .gpu = like.gpu, .viewport = like.viewport});
    const ModelId pyramid = world.models().add(
        make_mesh("trial", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
    world.bodies().add({.model = pyramid});
    world.bodies().add({.model = pyramid, .pose = Eigen::Isometry3d(Eigen::Translation3d(0.2, 0.1, 0.1))});
    world.step();
    return world.inspect().backend_note;
}

/// The outcome of a trial.
struct Tried {
    bool passed = false; ///< the trial with the GPU succeeded
    std::string note;    ///< why the CPU was chosen
};

bool may_become_cpu(BackendKind backend)
{
    return backend == BackendKind::automatic || backend == BackendKind::gl;
}

Tried tried(const Settings& settings)
{
    try {
        const std::string note =
            GraphicsProcess([&](std::string_view) { return play_two_bodies(settings); }).request({});
        return {.passed = note.empty(), .note = note};
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu || !may_become_cpu(settings.backend)) throw;
        return {.note = fmt::format("{}: the CPU was chosen; {}", name_of(settings.backend), error.what())};
    }
}

} // namespace

Settings with_tried_backend(Settings settings)
{
    if (settings.backend == BackendKind::cpu || memory_limit() == 0) return settings;
    // It is tried only once, when options are read: later there are threads, which a copy of the process would not
    // have.
    static std::map<std::tuple<BackendKind, int, int>, Tried> all;
    const auto [at, fresh] = all.try_emplace({settings.backend, settings.gpu, settings.viewport});
    if (fresh) at->second = tried(settings);
    if (!may_become_cpu(settings.backend) || at->second.passed) return settings;
    if (fresh) log(LogLevel::note, at->second.note);
    settings.backend = BackendKind::cpu;
    return settings;
}

} // namespace oncollide::tools
