#include "study/play.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

#include "cli/progress.hpp"
#include "common/race.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

void add(TreeStats& sum, const TreeStats& frame)
{
    sum.rounds += frame.rounds, sum.rows += frame.rows, sum.node_pairs += frame.node_pairs;
    sum.triangle_pairs += frame.triangle_pairs, sum.collapsed += frame.collapsed, sum.refused += frame.refused;
    sum.queries += frame.queries;
    sum.nodes = std::max(sum.nodes, frame.nodes), sum.bytes = std::max(sum.bytes, frame.bytes);
}

/// Keeps the least time of a frame; true if `now` is the least.
bool take_time(std::vector<double>& ms, int frame, double now)
{
    if (int(ms.size()) == frame) {
        ms.push_back(now);
        return true;
    }
    const bool less = now < ms[std::size_t(frame)];
    if (less) ms[std::size_t(frame)] = now;
    return less;
}

void take_times(StudyRow& row, const FrameView& view, int frame)
{
    row.stage_ms.resize(std::max(row.stage_ms.size(), std::size_t(frame) + 1));
    if (!take_time(row.ms, frame, view.ms)) return;
    auto& stages = row.stage_ms[std::size_t(frame)];
    for (std::size_t k = 0; k < stages.size(); ++k) stages[k] = view.stages[k].cpu_ms;
}

/// All variants and libraries, in their initial state.
struct Players {
    SceneTruth truth;
    std::vector<Pipeline> pipelines;
    std::vector<std::unique_ptr<StudyPlayer>> peers;

    Players(const StudyWorkload& workload, const std::vector<StudyRow>& rows, const std::vector<PeerKind>& kinds,
            const Settings& request)
        : truth(workload.scene, request)
    {
        for (const StudyRow& row : rows) pipelines.emplace_back(workload.scene, row.variant.settings);
        for (const PeerKind& kind : kinds) peers.push_back(kind.make(workload));
    }
};

bool left_over(std::span<const PairResult> answer, BodyPair pair)
{
    const auto bodies = [](const PairResult& result) { return BodyPair{index(result.a), index(result.b)}; };
    const auto at = std::ranges::lower_bound(answer, pair, {}, bodies);
    return at != answer.end() && bodies(*at) == pair && at->verdict != Verdict::separate;
}

void play_once(StudyWorkload& workload, Study& study, Players& all, int repeat, std::size_t bounds, Progress& progress)
{
    const bool first = repeat == 0;
    SceneTruth& truth = all.truth;
    auto& pipelines = all.pipelines;
    auto& peers = all.peers;                                      // structured bindings cannot be captured
    const std::size_t players = study.rows.size() + peers.size(); // peers come last
    for (int frame = 0; frame < workload.frames(); ++frame, progress.step()) {
        workload.move(frame);
        if (first) {
            truth.step();
            study.colliding += truth.colliding().size();
            if (const auto known = workload.known(frame)) study.contradicted += *known == truth.colliding().empty();
        }
        std::vector<std::span<const PairResult>> answers(study.rows.size());
        std::vector<BodyPair> fcl;
        take_turns(players, std::size_t(frame + repeat), [&](std::size_t k) {
            if (k >= study.rows.size()) {
                StudyPeer& peer = study.peers[k - study.rows.size()];
                const StudyPlayer::Result result = peers[k - study.rows.size()]->step();
                take_time(peer.ms, frame, result.ms);
                if (!first) return;
                peer.candidates += result.candidates;
                judge(peer, result.colliding, truth, workload.scene, workload.number(frame));
                if (peer.name == "FCL") fcl = result.colliding;
                return;
            }
            StudyRow& row = study.rows[k];
            const FrameView view = pipelines[k].step(workload.scene);
            take_times(row, view, frame);
            if (!first) return;
            judge(row, view.pairs, truth, workload.scene, frame, bounds), add(row.trees, view.trees);
            row.hashes.push_back(view.hash), answers[k] = view.pairs;
        });
        std::erase_if(fcl, [&](BodyPair pair) { return truth.collide(pair) || truth.open(pair); });
        for (std::size_t k = 0; k < study.rows.size() && first; ++k)
            study.rows[k].fcl_alone +=
                std::uint64_t(std::ranges::count_if(fcl, [&](BodyPair pair) { return !left_over(answers[k], pair); }));
    }
    if (!first) return;
    for (std::size_t k = 0; k < peers.size(); ++k) study.peers[k].bytes = peers[k]->bytes();
    for (std::size_t k = 0; k < study.rows.size(); ++k) {
        StudyRow& row = study.rows[k];
        WorldInfo info = pipelines[k].inspect();
        row.backend = std::move(info.backend);
        row.stages = std::move(info.totals);
    }
}

/// The request to all variants; variants without an exact level cannot recognise touching pairs.
Settings request_of(const std::vector<StudyVariant>& variants)
{
    Settings request = variants.front().settings;
    request.ignore_touching =
        std::ranges::any_of(variants, [](const StudyVariant& v) { return v.settings.ignore_touching; });
    return request;
}

} // namespace

double median_size(const Scene& scene)
{
    std::vector<double> sizes;
    for (GeometryId geometry : scene.geometry) sizes.push_back(bounds_of(scene.geometries[index(geometry)]).diagonal());
    return median(sizes);
}

Study play_study(StudyWorkload& workload, const std::vector<StudyVariant>& variants, std::vector<PeerKind> peers,
                 const PlayOptions& options)
{
    Study study;
    const Scene& scene = workload.scene;
    study.title = workload.title, study.bodies = scene.size();
    study.frames = workload.frames(), study.warm_up = std::min(options.warm_up, workload.frames() - 1);
    study.size = median_size(scene);
    for (const Geometry& geometry : scene.geometries)
        if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) study.triangles += mesh->triangles.size();
    for (const StudyVariant& variant : variants) study.rows.emplace_back().variant = variant;
    const Settings request = request_of(variants);
    if (!options.any_peer) study.left_out = leave_out(peers, workload, request);
    for (const PeerKind& kind : peers) study.peers.emplace_back().name = kind.library;
    {
        Progress progress("frame", std::size_t(workload.frames()) * std::size_t(options.repeats));
        std::optional<Players> players;
        for (int repeat = 0; repeat < options.repeats; ++repeat) {
            workload.move(0);
            if (!players || !workload.is_poses()) players.emplace(workload, study.rows, peers, request);
            play_once(workload, study, *players, repeat, options.bounds, progress);
        }
    }
    if (options.needed) count_needed(workload, study);
    return study;
}

} // namespace oncollide::tools
