#include <oncollide/pipeline/pipeline.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/pipeline/exact_stages.hpp>

namespace oncollide {

namespace {

constexpr std::array<std::string_view, 5> stage_names{"bounds", "delimitation", "broad", "ocst", "exact"};

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration d)
{
    return std::chrono::duration<double, std::milli>(d).count();
}

void mix(std::uint64_t& hash, std::uint64_t value)
{
    hash = splitmix(hash ^ value);
}

std::uint64_t hash_of(std::span<const PairResult> results, bool with_kinds)
{
    std::uint64_t hash = 0;
    for (const PairResult& r : results) {
        if (r.verdict == Verdict::separate) continue;
        mix(hash, static_cast<std::uint64_t>(index(r.a)) << 32 | index(r.b));
        mix(hash, static_cast<std::uint64_t>(r.verdict) << 8 | r.stage);
        if (with_kinds) mix(hash, static_cast<std::uint64_t>(r.kind));
        mix(hash, std::bit_cast<std::uint64_t>(r.bound));
    }
    return hash;
}

/// `auto` takes a GPU only if it is one: software renderers are slower than the cpu backend.
std::unique_ptr<OcclusionBackend> make_automatic_backend(int gpu, std::string& note)
{
    try {
        const std::vector<GpuDevice> devices = gpu_devices();
        const auto hardware = [](const GpuDevice& d) { return !d.software; };
        if (gpu < 0 && std::none_of(devices.begin(), devices.end(), hardware)) {
            note = "auto: the CPU answers, for only software renderers are here";
            return make_cpu_backend();
        }
        const GpuInfo info = describe_gpu(gpu);
        if (!info.software) return make_gl_compute_backend({.gpu = gpu});
        note = fmt::format("auto: the CPU answers, for {} is a software renderer", info.renderer);
    } catch (const Error& error) {
        note = fmt::format("auto: the CPU answers; {}", error.what());
    }
    return make_cpu_backend();
}

/// @param note  why it is not a GPU, when that was left to us
std::unique_ptr<OcclusionBackend> make_backend(const Settings& settings, std::string& note)
{
    switch (settings.backend) {
    case BackendKind::automatic:
        return make_automatic_backend(settings.gpu, note);
    case BackendKind::gl_compute:
        return make_gl_compute_backend({.gpu = settings.gpu});
    case BackendKind::gl_query:
        return make_gl_query_backend({.gpu = settings.gpu, .viewport = settings.viewport});
    default:
        return make_cpu_backend();
    }
}

/// Rigid within 1e-6: what the bounds allow for. Distances between far bodies must stay finite in float.
bool usable(const Eigen::Isometry3d& pose)
{
    const Eigen::Matrix3d r = pose.linear();
    return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= 1e-6 && r.determinant() > 0 &&
           pose.translation().cwiseAbs().maxCoeff() <= 1e15;
}

} // namespace

struct Pipeline::Impl {
    Settings settings;
    Frame frame;
    std::vector<std::unique_ptr<Stage>> stages;
    std::vector<std::uint8_t> asked_to_skip;
    std::vector<StageStats> stats, totals;
    std::size_t bodies = 0;
    std::vector<std::uint32_t> moving;
    std::unique_ptr<BroadPhase> boxes;
    std::unique_ptr<Forest> forest;
    std::string backend_note;
    std::uint64_t hash = 0;
    bool first = true;

    void check_poses(const Scene& scene)
    {
        if (scene.size() != bodies)
            throw Error(ErrorKind::usage,
                        fmt::format("the pipeline was made for {} bodies, the scene has {}", bodies, scene.size()));
        const auto check_one = [&](std::uint32_t body) {
            if (!usable(scene.poses[body]))
                throw Error(
                    ErrorKind::bad_data,
                    fmt::format("body '{}': pose is not a finite rigid motion within 1e15 m", scene.names[body]));
        };
        if (first)
            for (std::uint32_t body = 0; body < scene.size(); ++body) check_one(body);
        else
            for (std::uint32_t body : moving) check_one(body);
        first = false;
    }
};

Pipeline::Pipeline(const Scene& scene, const Settings& settings, std::unique_ptr<OcclusionBackend> backend)
    : impl_(std::make_unique<Impl>())
{
    check(settings);
    Impl& p = *impl_;
    p.settings = settings;
    p.frame.settings = &p.settings;
    p.frame.threads = settings.threads ? settings.threads : hardware_threads();
    p.bodies = scene.size();
    for (std::uint32_t body = 0; body < scene.size(); ++body)
        if (!scene.is_static[body]) p.moving.push_back(body);

    if (!backend) backend = make_backend(settings, p.backend_note);
    p.forest = std::make_unique<Forest>(scene, p.settings, std::move(backend));
    p.boxes = make_kd_tree({.margin = settings.clearance, .threads = p.frame.threads});
    p.stages.push_back(make_bounds_stage(scene));
    p.stages.push_back(make_delimitation_stage(scene, p.settings, *p.boxes));
    p.stages.push_back(make_broad_stage(scene, settings.broad_phase, *p.boxes));
    p.stages.push_back(make_ocst_stage(p.settings, *p.forest));
    p.stages.push_back(settings.exact == ExactLevel::predicates ? make_predicates_stage(scene, p.settings, *p.forest)
                                                                : make_fcl_stage(scene, p.settings, *p.forest));
    p.asked_to_skip.assign(p.stages.size(), 0);
    for (const std::string& name : settings.skip) {
        const auto found = std::find(stage_names.begin(), stage_names.end(), name);
        if (found == stage_names.end())
            throw Error(ErrorKind::usage,
                        fmt::format("skip: no stage named '{}'; valid: {}", name, fmt::join(stage_names, ", ")));
        p.asked_to_skip[static_cast<std::size_t>(found - stage_names.begin())] = 1;
    }
    p.stats.resize(p.stages.size()), p.totals.resize(p.stages.size());
    for (std::size_t i = 0; i < p.stages.size(); ++i) {
        p.totals[i].stage = p.stages[i]->name(), p.totals[i].unit = p.stages[i]->unit();
        p.totals[i].skipped = true;
    }
}

Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;

FrameView Pipeline::step(const Scene& scene)
{
    Impl& p = *impl_;
    const auto begin = p.frame.began = Clock::now();
    p.check_poses(scene);
    if (!p.forest->lost().empty() && p.settings.backend != BackendKind::automatic)
        throw Error(ErrorKind::no_gpu, fmt::format("frame {}: the GPU was lost in an earlier frame, which the CPU "
                                                   "finished: {}; to go on without it use --backend auto or cpu",
                                                   p.frame.number, p.forest->lost()));
    auto from = begin;
    for (std::size_t i = 0; i < p.stages.size(); ++i) {
        Stage& stage = *p.stages[i];
        StageStats& stats = p.stats[i];
        stats = {};
        stats.stage = stage.name(), stats.unit = stage.unit(), stats.frames = 1;
        stats.note = p.asked_to_skip[i] ? "asked to" : stage.reason_to_skip(scene, p.frame);
        stats.skipped = !stats.note.empty();
        if (stats.skipped)
            stage.skip(scene, p.frame, stats);
        else
            stage.run(scene, p.frame, stats);
        stats.culled = stats.in - stats.out;
        const auto to = Clock::now();
        stats.cpu_ms = milliseconds(to - from);
        from = to;

        StageStats& total = p.totals[i];
        total.frames += 1, total.in += stats.in, total.out += stats.out, total.culled += stats.culled;
        total.undecided += stats.undecided, total.cpu_ms += stats.cpu_ms, total.gpu_ms += stats.gpu_ms;
        total.wait_ms += stats.wait_ms;
        total.skipped &= stats.skipped, total.note = total.skipped ? stats.note : std::string_view{};
    }
    p.frame.trees.collapsed = p.forest->age(p.frame.number);
    p.frame.trees.nodes = p.forest->nodes();
    p.frame.trees.bytes = p.forest->bytes();
    const std::uint64_t hash = hash_of(p.frame.results, wants_kinds(p.settings));
    mix(p.hash, hash);
    const FrameView view{p.frame.number,       milliseconds(Clock::now() - begin),
                         p.frame.results,      p.stats,
                         p.frame.delimitation, p.frame.trees,
                         p.frame.rounds,       hash};
    ++p.frame.number;
    return view;
}

std::span<const std::string_view> Pipeline::stages() const
{
    return stage_names;
}
std::span<const StageStats> Pipeline::totals() const
{
    return impl_->totals;
}
std::uint64_t Pipeline::hash() const
{
    return impl_->hash;
}
std::string Pipeline::backend() const
{
    return impl_->forest->backend().name();
}
std::string Pipeline::renderer() const
{
    return impl_->forest->backend().renderer();
}
std::string Pipeline::backend_note() const
{
    const std::string& lost = impl_->forest->lost();
    return lost.empty() ? impl_->backend_note : "the CPU answers since the GPU was lost: " + lost;
}
const Settings& Pipeline::settings() const
{
    return impl_->settings;
}
const Ocst* Pipeline::tree(GeometryId geometry) const
{
    return impl_->forest->grown(geometry);
}

void Pipeline::replace(std::unique_ptr<Stage> stage)
{
    for (auto& mine : impl_->stages)
        if (mine->name() == stage->name()) {
            mine = std::move(stage);
            return;
        }
    throw Error(ErrorKind::usage,
                fmt::format("replace: no stage named '{}'; valid: {}", stage->name(), fmt::join(stage_names, ", ")));
}

} // namespace oncollide
