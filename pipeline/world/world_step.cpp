// World: construction and frames.
#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/pipeline/world/world_impl.hpp>

namespace oncollide {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration d)
{
    return std::chrono::duration<double, std::milli>(d).count();
}

/// Also counts the undecided results, which costs nothing beside the hash.
std::uint64_t hash_of(std::span<const PairResult> results, std::span<const PairSweep> sweeps, bool with_kinds,
                      std::size_t& undecided)
{
    std::uint64_t hash = 0;
    undecided = 0;
    const auto add = [&](std::size_t begin, std::size_t end) {
        for (const PairResult& result : results.subspan(begin, end - begin)) {
            mix(hash, result, with_kinds);
            undecided += result.verdict == Verdict::undecided;
        }
    };
    std::size_t begin = 0;
    for (const PairSweep& sweep : sweeps) {
        add(std::exchange(begin, sweep.pair + 1), sweep.pair + 1);
        mix(hash, results[sweep.pair], {sweep.clear_until, sweep.contact_by});
    }
    add(begin, results.size());
    return hash;
}

void add_to(StageStats& total, const StageStats& s)
{
    total.frames += 1, total.in += s.in, total.out += s.out, total.culled += s.culled;
    total.undecided += s.undecided, total.cpu_ms += s.cpu_ms, total.gpu_ms += s.gpu_ms, total.wait_ms += s.wait_ms;
    total.skipped &= s.skipped, total.note = total.skipped ? s.note : std::string_view{};
}

/// Used for tests of every pair: where nothing changed, bounds are the last ones, as if the pairs had not been tested.
void keep_bounds(Frame& frame)
{
    if (!frame.keeps) return;
    for (const PairRun& run : frame.cache.unchanged())
        for (std::uint32_t i = 0; i < run.count; ++i) {
            const PairResult& last = frame.last_results[run.before + i];
            PairResult& now = frame.results[run.now + i];
            if (last.verdict == Verdict::separate && now.verdict == Verdict::separate) now.bound = last.bound;
        }
}

/// `auto` uses only hardware GPUs: software renderers are slower than the cpu backend.
std::unique_ptr<OcclusionBackend> make_automatic_backend(int gpu, std::string& note)
{
    try {
        const std::vector<GpuDevice> devices = gpu_devices();
        const auto hardware = [](const GpuDevice& d) { return !d.software; };
        if (gpu < 0 && std::none_of(devices.begin(), devices.end(), hardware)) {
            note = "auto: the CPU was chosen, because there are only software renderers";
            return make_cpu_backend();
        }
        const GpuInfo info = describe_gpu(gpu);
        if (!info.software) return make_gl_compute_backend({.gpu = gpu});
        note = fmt::format("auto: the CPU was chosen, because {} is a software renderer", info.renderer);
    } catch (const Error& error) {
        note = fmt::format("auto: the CPU was chosen; {}", error.what());
    }
    return make_cpu_backend();
}

/// @param note  why `auto` did not choose a GPU
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

std::unique_ptr<BroadPhase> make_broad_phase(BroadPhaseKind kind, const BroadPhase::Options& options)
{
    switch (kind) {
    case BroadPhaseKind::octree:
        return make_octree(options);
    case BroadPhaseKind::brute_force:
        return make_brute_force(options);
    default:
        return make_kd_tree(options);
    }
}

} // namespace

/// @param backend  null: as the settings say
/// @param gpu_options  for the backend gl; its gpu is replaced by the settings'
std::unique_ptr<WorldImpl> WorldImpl::make(const Settings& settings, std::unique_ptr<OcclusionBackend> backend,
                                           const MeshWalkOptions& gpu_options)
{
    check(settings);
    std::string note;
    if (!backend) backend = make_backend(settings, note);
    Settings resolved = settings;
    resolved.exact = exact_level(settings);
    auto made = std::make_unique<WorldImpl>(resolved, std::move(backend), std::move(note));

    WorldImpl& p = *made;
    p.requested_exact = settings.exact;
    if (settings.backend == BackendKind::gl) {
        MeshWalkOptions options = gpu_options;
        options.gpu = settings.gpu;
        p.gpu = std::make_unique<GpuPairs>(options);
    }
    p.broad =
        make_broad_phase(settings.broad_phase, {.margin = settings.clearance, .threads = p.frame.context.threads});
    p.stages.push_back(make_bounds_stage());
    p.stages.push_back(make_delimitation_stage(*p.broad));
    p.stages.push_back(make_broad_stage(*p.broad));
    p.stages.push_back(make_refine_stage(p.settings, p.models, p.gpu.get()));
    p.stages.push_back(make_exact_stage(p.settings, p.models, p.gpu.get()));
    for (auto* stats : {&p.stats, &p.totals, &p.blank}) stats->resize(p.stages.size());
    for (std::size_t i = 0; i < p.stages.size(); ++i) {
        p.skipped.push_back(!p.runs(p.stages[i]->id()));
        p.blank[i].stage = p.totals[i].stage = name_of(p.stages[i]->id());
        p.blank[i].unit = p.totals[i].unit = p.stages[i]->unit();
        p.blank[i].frames = 1, p.totals[i].skipped = true;
    }
    p.frame.whole = !p.runs(StageId::delimitation);
    return made;
}

World::World(const Settings& settings) : impl_(WorldImpl::make(settings, nullptr, {})) {}

bool WorldImpl::runs(StageId stage) const
{
    return !settings.skip.contains(stage);
}

void WorldImpl::take_in_changes()
{
    BodyChanges& changes = frame.changes;
    bodies.take_changes(changes);
    frame.fresh.resize(bodies.slots()), frame.changed.resize(bodies.slots());
    frame.fresh.add(changes.fresh), frame.changed.add(changes.fresh), frame.changed.add(changes.moved);
    frame.same_bodies &= changes.empty() && frame.exclusions_version == bodies.exclusions_version();
    frame.exclusions_version = bodies.exclusions_version();
    frame.moved += changes.added_dynamic.size() + changes.moved.size();
    broad->remove(changes.removed);
    broad->add(changes.added_dynamic), broad->add(changes.added_static, true);
    broad->move(changes.moved);
    broad->make_static(changes.made_static), broad->make_dynamic(changes.made_dynamic);
}

void World::set_pair_filter(PairFilter filter)
{
    impl().frame.filter = std::move(filter);
    impl().frame.same_bodies = false;
}

FrameView World::step()
{
    WorldImpl& p = impl();
    const ExecutorScope scope(p.settings.executor);
    Frame& frame = p.frame;
    const auto begin = frame.context.began = Clock::now();
    if (!p.models.lost().empty() && p.settings.backend != BackendKind::automatic)
        throw Error(ErrorKind::no_gpu, fmt::format("frame {}: the GPU was lost in an earlier frame, which the CPU "
                                                   "completed: {}; to continue without it, use --backend auto or cpu",
                                                   frame.number, p.models.lost()));
    frame.context.trees = {}, frame.context.rounds.clear(), frame.context.frame = frame.number;
    p.take_in_changes();
    frame.sweeps.clear();
    if (p.rests()) {
        p.repeat_stages();
        p.frame_manifolds.repeat(frame.number);
    } else {
        try {
            p.run_stages();
            if (!p.settings.coherence) keep_bounds(frame);
            p.find_events();
            p.look_ahead();
            p.frame_hash = hash_of(frame.results, frame.sweeps, wants_kinds(p.settings), frame.undecided);
        } catch (...) {
            frame.keeps = false; // some results may be of this frame
            throw;
        }
    }
    ONCOLLIDE_ASSERT_VALID(p.validate());
    frame.ended = true;
    frame.keeps = !p.settings.node_budget && !p.settings.memory_budget && !p.settings.resident_budget;
    for (std::size_t i = 0; i < p.stages.size(); ++i) add_to(p.totals[i], p.stats[i]);
    frame.fresh.clear(), frame.changed.clear(), frame.moved = 0, frame.same_bodies = true;

    if (p.bodies.any_motion()) p.bodies.end_motions(), p.changed();
    p.changed_since_step = false;
    TreeStats& trees = frame.context.trees;
    trees.collapsed = p.models.age(frame.number);
    p.with_tree.store(nullptr, std::memory_order_relaxed);
    trees.nodes = p.models.nodes();
    trees.bytes = p.models.bytes();
    mix(p.hash, p.frame_hash);
    return {frame.number++, milliseconds(Clock::now() - begin),
            frame.results,  p.began,
            p.ended,        p.stats,
            p.totals,       frame.delimitation,
            trees,          frame.context.rounds,
            p.frame_hash,   frame.sweeps};
}

void WorldImpl::run_stages()
{
    auto from = frame.context.began;
    for (std::size_t i = 0; i < stages.size(); ++i) {
        Stage& stage = *stages[i];
        StageStats& s = stats[i];
        s = blank[i];
        s.note = skipped[i] ? by_request : stage.reason_to_skip(bodies, frame);
        s.skipped = !s.note.empty();
        if (s.skipped)
            stage.skip(bodies, frame, s);
        else
            stage.run(bodies, frame, s);
        s.culled = s.in - s.out;
        // A stage that skips itself costs less than reading the clock, so it is not timed.
        const auto to = s.skipped && !skipped[i] ? from : Clock::now();
        s.cpu_ms = milliseconds(to - from);
        from = to;
    }
    if (!bodies.any_motion()) return;
    sweeps.run(bodies, frame, stats.back());
    stats.back().cpu_ms += milliseconds(Clock::now() - from);
}

bool WorldImpl::rests() const
{
    return frame.keeps && frame.same_bodies && settings.coherence && !frame.filter && frame.undecided == 0;
}

void WorldImpl::repeat_stages()
{
    frame.delimitation.clear(), began.clear(), ended.clear();
    for (StageStats& s : stats) s.cpu_ms = s.gpu_ms = s.wait_ms = 0;
    frame.context.trees.kept = frame.results.size();
}

/// Examines the bodies, the memory of pairs, and the trees of one body's model, another one in each frame. Large
/// structures are examined in every 16th frame.
std::string WorldImpl::validate() const
{
    constexpr std::size_t small = 4096;
    const bool all = frame.number % 16 == 0;
    if (all || bodies.slots() <= small)
        if (std::string fault = bodies.validate(); !fault.empty()) return fault;
    if (all || frame.pairs.size() <= small)
        if (std::string fault = frame.cache.validate(); !fault.empty()) return fault;
    const std::uint32_t slot = bodies.slots() ? frame.number % bodies.slots() : 0;
    return bodies.alive(slot) ? bodies.model(slot).validate(all ? 16 * small : small / 16) : "";
}

/// Lets the prefetcher prepare the parts of cooked meshes that moving bodies will reach next.
void WorldImpl::look_ahead()
{
    if (settings.look_ahead == 0 || !reads_on_demand(settings)) return;
    std::vector<PrefetchPart> parts = forecast.find(bodies, frame.changes.moved, *broad, frame.number,
                                                    static_cast<std::uint32_t>(settings.look_ahead));
    if (!parts.empty()) models.look_ahead(std::move(parts));
}

/// Compares the results of two frames, except in the runs of pairs that kept their results.
void WorldImpl::find_events()
{
    began.clear(), ended.clear();
    const std::span<const PairResult> now = frame.results, last = frame.last_results;
    std::size_t i = 0, k = 0;
    for (const PairRun& run : frame.kept) {
        find_events(now.subspan(i, run.now - i), last.subspan(k, run.before - k));
        i = run.now_end(), k = run.before_end();
    }
    find_events(now.subspan(i), last.subspan(k));
}

/// Merges the two lists, which are sorted by slots. A reused slot has another generation, so its pairs are new pairs.
void WorldImpl::find_events(std::span<const PairResult> now, std::span<const PairResult> last)
{
    const auto slots = [](const PairResult& pair) { return BodyPair{pair.a.slot, pair.b.slot}; };
    const auto add = [](std::vector<PairOfBodies>& events, const PairResult& pair) {
        if (pair.verdict != Verdict::separate) events.push_back({pair.a, pair.b});
    };
    std::size_t i = 0, k = 0;
    while (i < now.size() && k < last.size()) {
        if (slots(now[i]) < slots(last[k])) {
            add(began, now[i++]);
        } else if (slots(last[k]) < slots(now[i])) {
            add(ended, last[k++]);
        } else {
            const bool same = now[i].a == last[k].a && now[i].b == last[k].b;
            if (!same || last[k].verdict == Verdict::separate) add(began, now[i]);
            if (!same || now[i].verdict == Verdict::separate) add(ended, last[k]);
            ++i, ++k;
        }
    }
    for (; i < now.size(); ++i) add(began, now[i]);
    for (; k < last.size(); ++k) add(ended, last[k]);
}

WorldInfo World::inspect() const
{
    WorldImpl& p = impl();
    const std::lock_guard lock(p.guard); // queries make trees and take in changes meanwhile
    return {.bodies = p.bodies.size(),
            .models = p.models.size(),
            .frames = p.frame.number,
            .bytes = p.bodies.bytes() + p.broad->bytes() + p.models.bytes() + p.models.links_bytes() +
                     p.frame.cache.bytes() + p.frame_manifolds.bytes(),
            .backend = p.name_of_backend(),
            .renderer = p.gpu ? p.gpu->renderer() : p.models.backend().renderer(),
            .backend_note = p.note_on_backend(),
            .totals = p.totals,
            .regions = p.frame.delimitation.empty() ? std::vector<DelimitedRegion>{} : p.broad->regions(),
            .file_faults = p.models.faults()};
}
std::uint64_t World::hash() const
{
    return impl().hash;
}
void WorldAccess::continue_from(World& world, std::uint32_t frame, std::uint64_t hash)
{
    world.impl().frame.number = frame, world.impl().hash = hash;
}

} // namespace oncollide
