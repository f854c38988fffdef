#include "study/play.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include <oncollide/scenes/error.hpp>

#include "bench.hpp"
#include "progress.hpp"
#include "study/needed.hpp"
#include "study/truth.hpp"

namespace oncollide::tools {
namespace {

constexpr std::size_t most_errors = 10; ///< of FCL, in words

void add(TreeStats& sum, const TreeStats& frame)
{
    sum.rounds += frame.rounds, sum.rows += frame.rows, sum.node_pairs += frame.node_pairs;
    sum.triangle_pairs += frame.triangle_pairs, sum.collapsed += frame.collapsed, sum.refused += frame.refused;
    sum.queries += frame.queries;
    sum.nodes = std::max(sum.nodes, frame.nodes), sum.bytes = std::max(sum.bytes, frame.bytes);
}

void judge_alarm(StudyRow& row, const Sighting& alarm, double lower)
{
    ++row.false_alarms;
    row.alarm_distances.push_back(alarm.distance);
    const double share = alarm.bound > 0 ? alarm.distance / alarm.bound : 0;
    ++row.alarms_by_share[std::min(alarm_bins - 1, std::size_t(share * double(alarm_bins)))];
    row.broken += lower > alarm.bound;
    if (!row.worst_alarm || alarm.distance > row.worst_alarm->distance) row.worst_alarm = alarm;
}

void judge(StudyRow& row, const FrameView& view, StudyTruth& truth, int frame)
{
    std::uint64_t found = 0;
    for (const PairResult& pair : view.pairs) {
        ++row.verdicts[std::size_t(pair.verdict)];
        if (pair.verdict == Verdict::separate) continue;
        const BodyPair bodies{index(pair.a), index(pair.b)};
        row.error = std::max(row.error, pair.bound);
        if (truth.collide(bodies)) {
            ++found;
        } else if (pair.verdict == Verdict::colliding) {
            ++row.invented;
        } else {
            const MeshDistance distance = truth.distance(bodies);
            judge_alarm(row, {frame, bodies, distance.upper, pair.bound}, distance.lower);
        }
    }
    if (found == truth.colliding().size()) return;
    row.missed += truth.colliding().size() - found;
    if (row.first_miss) return;
    const auto left_over = [&](BodyPair pair) {
        return std::ranges::any_of(view.pairs, [&](const PairResult& p) {
            return BodyPair{index(p.a), index(p.b)} == pair && p.verdict != Verdict::separate;
        });
    };
    for (BodyPair pair : truth.colliding())
        if (!left_over(pair)) {
            row.first_miss = Sighting{frame, pair};
            break;
        }
}

void judge(StudyFcl& fcl, const FclFrame& answer, StudyTruth& truth, const StudyCourse& course, int frame)
{
    fcl.candidates += answer.candidates, fcl.colliding += answer.colliding.size();
    const auto tell = [&](BodyPair pair, std::string_view what) {
        if (fcl.errors.size() < most_errors)
            fcl.errors.push_back(fmt::format("frame {}: {} {} and {}", course.number(frame), what,
                                             course.scene.names[pair.a], course.scene.names[pair.b]));
    };
    for (BodyPair pair : truth.colliding())
        if (!std::ranges::binary_search(answer.colliding, pair)) ++fcl.missed, tell(pair, "misses");
    for (BodyPair pair : answer.colliding)
        if (!truth.collide(pair)) {
            ++fcl.invented;
            tell(pair, fmt::format("calls colliding, at {:.3g} m,", truth.distance(pair).upper));
        }
}

/// Keeps the least time of a frame; true when this one is it.
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

/// Everybody who plays, from nothing.
struct Players {
    FclWorld world;
    StudyTruth truth;
    std::vector<Pipeline> pipelines;

    Players(const Scene& scene, const std::vector<StudyRow>& rows)
        : world(scene), truth(scene, rows.front().variant.settings, world)
    {
        for (const StudyRow& row : rows) pipelines.emplace_back(scene, row.variant.settings);
    }
};

void play_once(StudyCourse& course, Study& study, Players& all, int repeat, Progress& progress)
{
    const bool first = repeat == 0;
    auto& [world, truth, pipelines] = all;
    if (study.fcl) study.fcl->bytes = world.model_bytes().obb;
    const std::size_t players = study.rows.size() + 1; // FCL is the last
    for (int frame = 0; frame < course.frames(); ++frame, progress.step()) {
        course.move(frame);
        if (first) {
            truth.step();
            study.colliding += truth.colliding().size();
            if (const auto known = course.known(frame)) study.contradicted += *known == truth.colliding().empty();
        }
        for (std::size_t turn = 0; turn < players; ++turn) {
            const std::size_t k = (turn + std::size_t(frame + repeat)) % players;
            if (k == study.rows.size()) {
                if (!study.fcl) continue;
                const FclFrame answer = world.step();
                take_time(study.fcl->ms, frame, answer.ms());
                if (first) judge(*study.fcl, answer, truth, course, frame);
                continue;
            }
            StudyRow& row = study.rows[k];
            const FrameView view = pipelines[k].step(course.scene);
            take_times(row, view, frame);
            if (first) judge(row, view, truth, frame), add(row.trees, view.trees);
        }
    }
    if (!first) return;
    for (std::size_t k = 0; k < study.rows.size(); ++k) {
        StudyRow& row = study.rows[k];
        row.backend = pipelines[k].backend();
        row.stages.assign(pipelines[k].totals().begin(), pipelines[k].totals().end());
    }
}

} // namespace

Study play_study(StudyCourse& course, const std::vector<StudyVariant>& variants, int warm_up, int repeats)
{
    Study study;
    const Scene& scene = course.scene;
    study.title = course.title, study.bodies = scene.size();
    study.frames = course.frames(), study.warm_up = std::min(warm_up, course.frames() - 1);
    std::vector<double> sizes;
    for (GeometryId geometry : scene.geometry) sizes.push_back(bounds_of(scene.geometries[index(geometry)]).diagonal());
    study.size = median(sizes);
    for (const Geometry& geometry : scene.geometries)
        if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) study.triangles += mesh->triangles.size();
    for (const StudyVariant& variant : variants) study.rows.emplace_back().variant = variant;
    const Settings& asked = variants.front().settings;
    if (asked.clearance == 0 && asked.mode == Mode::surface) study.fcl.emplace();
    {
        Progress progress("frame", std::size_t(course.frames()) * std::size_t(repeats));
        std::optional<Players> players;
        for (int repeat = 0; repeat < repeats; ++repeat) {
            course.move(0);
            if (!players || !course.is_poses()) players.emplace(scene, study.rows);
            play_once(course, study, *players, repeat, progress);
        }
    }
    count_needed(course, study);
    return study;
}

} // namespace oncollide::tools
