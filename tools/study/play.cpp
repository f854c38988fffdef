#include "study/play.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

#include "bench/bench.hpp"
#include "cli/progress.hpp"

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
        for (const PeerKind& kind : kinds) peers.push_back(make_player(kind, workload));
    }
};

void play_once(StudyWorkload& workload, Study& study, Players& all, int repeat, Progress& progress)
{
    const bool first = repeat == 0;
    auto& [truth, pipelines, peers] = all;
    const std::size_t players = study.rows.size() + peers.size(); // peers come last
    for (int frame = 0; frame < workload.frames(); ++frame, progress.step()) {
        workload.move(frame);
        if (first) {
            truth.step();
            study.colliding += truth.colliding().size();
            if (const auto known = workload.known(frame)) study.contradicted += *known == truth.colliding().empty();
        }
        for (std::size_t turn = 0; turn < players; ++turn) {
            const std::size_t k = (turn + std::size_t(frame + repeat)) % players;
            if (k >= study.rows.size()) {
                StudyPeer& peer = study.peers[k - study.rows.size()];
                const StudyPlayer::Result result = peers[k - study.rows.size()]->step();
                take_time(peer.ms, frame, result.ms);
                if (!first) continue;
                peer.candidates += result.candidates;
                judge(peer, result.colliding, truth, workload.scene, workload.number(frame));
                continue;
            }
            StudyRow& row = study.rows[k];
            const FrameView view = pipelines[k].step(workload.scene);
            take_times(row, view, frame);
            if (first) judge(row, view.pairs, truth, frame), add(row.trees, view.trees);
        }
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

Study play_study(StudyWorkload& workload, const std::vector<StudyVariant>& variants, std::vector<PeerKind> peers,
                 int warm_up, int repeats)
{
    Study study;
    const Scene& scene = workload.scene;
    study.title = workload.title, study.bodies = scene.size();
    study.frames = workload.frames(), study.warm_up = std::min(warm_up, workload.frames() - 1);
    std::vector<double> sizes;
    for (GeometryId geometry : scene.geometry) sizes.push_back(bounds_of(scene.geometries[index(geometry)]).diagonal());
    study.size = median(sizes);
    for (const Geometry& geometry : scene.geometries)
        if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) study.triangles += mesh->triangles.size();
    for (const StudyVariant& variant : variants) study.rows.emplace_back().variant = variant;
    const Settings request = request_of(variants);
    study.left_out = leave_out(peers, workload, request);
    for (const PeerKind& kind : peers) study.peers.emplace_back().name = kind.library;
    {
        Progress progress("frame", std::size_t(workload.frames()) * std::size_t(repeats));
        std::optional<Players> players;
        for (int repeat = 0; repeat < repeats; ++repeat) {
            workload.move(0);
            if (!players || !workload.is_poses()) players.emplace(workload, study.rows, peers, request);
            play_once(workload, study, *players, repeat, progress);
        }
    }
    count_needed(workload, study);
    return study;
}

} // namespace oncollide::tools
