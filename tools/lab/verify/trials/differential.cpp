#include "verify/trials/differential.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <numeric>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/runs/pipeline.hpp>

#include "truth/judge.hpp"

namespace oncollide::tools {
namespace {

using FrameResults = std::map<std::pair<std::uint32_t, std::uint32_t>, Finding>; ///< for all candidate pairs

/// Plays the scene; calls look(scene, results) after each frame.
void run(Scene scene, const Settings& settings, auto look)
{
    Pipeline pipeline(scene, settings);
    Mover mover;
    for (int frame = 0; frame < scene.frames; ++frame) {
        mover.move(scene, frame);
        FrameResults results;
        for (const PairResult& pair : pipeline.step(scene).pairs) results[{pair.a.slot, pair.b.slot}] = pair;
        look(scene, results);
    }
}

std::vector<FrameResults> results_of(const Scene& scene, const Settings& settings)
{
    std::vector<FrameResults> all;
    run(scene, settings, [&](const Scene&, const FrameResults& results) { all.push_back(results); });
    return all;
}

const GeometryData& data_of(const Scene& scene, std::uint32_t body)
{
    return scene.geometries[index(scene.geometry[body])].data;
}

/// Fills `all` with the results of each frame.
std::string fault_against_truth(const DrawnScene& drawn, std::vector<FrameResults>& all)
{
    const Settings& s = drawn.settings;
    std::string fault;
    int frame = 0;
    std::deque<TruthModel> models;
    for (std::uint32_t body = 0; body < drawn.scene.size(); ++body)
        models.emplace_back(data_of(drawn.scene, body), s.mode == Mode::solid);
    run(drawn.scene, s, [&](const Scene& scene, const FrameResults& results) {
        all.push_back(results);
        const auto bodies = static_cast<std::uint32_t>(scene.size());
        for (std::uint32_t a = 0; a < bodies && fault.empty(); ++a)
            for (std::uint32_t b = a + 1; b < bodies && fault.empty(); ++b) {
                const auto listed = results.find({a, b});
                const Finding found = listed != results.end() ? listed->second : unlisted(s);
                const PairTruth truth = truth_of(models[a], scene.poses[a], models[b], scene.poses[b]);
                if (const Judgement judgement = judge(found, truth, s); !judgement.right())
                    fault =
                        fmt::format("frame {}, bodies {} and {}: {}", frame, a, b, described(found, truth, judgement));
            }
        ++frame;
    });
    return fault;
}

using BodyChange = std::function<void(std::size_t body, GeometryData&, BodyInit&)>;

/// The bodies of these numbers, in this order, with changes.
Scene rebuilt(const Scene& scene, const std::vector<std::size_t>& bodies, const BodyChange& change = {})
{
    Scene other;
    other.name = scene.name, other.frames = scene.frames;
    for (const std::size_t i : bodies) {
        const Geometry& geometry = scene.geometries[index(scene.geometry[i])];
        GeometryData data = geometry.data;
        BodyInit body{.name = std::string(scene.names[i]), .pose = scene.start_pose(i), .motion = scene.motions[i]};
        if (change) change(i, data, body);
        body.geometry = other.add(geometry.name, std::move(data));
        other.add_body(body);
    }
    return other;
}

std::vector<std::size_t> all_of(const Scene& scene)
{
    std::vector<std::size_t> bodies(scene.size());
    std::iota(bodies.begin(), bodies.end(), std::size_t(0));
    return bodies;
}

/// @param results  of the unchanged scene
std::string fault_against_others(const DrawnScene& drawn, const std::vector<FrameResults>& results)
{
    // Within a budget, cells that a hint saves are available to other pairs.
    const bool budget = drawn.settings.node_budget || drawn.settings.memory_budget;
    constexpr std::pair<const char*, void (*)(Settings&)> changes[] = {
        {"another number of threads", [](Settings& s) { s.threads = s.threads % 3 + 1; }},
        {"another broad phase",
         [](Settings& s) {
             s.broad_phase =
                 s.broad_phase == BroadPhaseKind::kd_tree ? BroadPhaseKind::octree : BroadPhaseKind::kd_tree;
         }},
        {"coherence switched", [](Settings& s) { s.coherence = !s.coherence; }}};
    for (const auto& [what, change] : std::span(changes).first(budget ? 2 : 3)) {
        Settings other = drawn.settings;
        change(other);
        if (results_of(drawn.scene, other) != results) return fmt::format("different results with {}", what);
    }
    // The order of a pair changes rounding, and budgets depend on order: only exact verdicts on the grid are compared.
    const bool exact = exact_level(drawn.settings) == ExactLevel::predicates && !budget;
    const bool quarter_turns = std::ranges::all_of(drawn.scene.poses, [](const Eigen::Isometry3d& pose) {
        return pose.linear().cwiseAbs().sum() == 3 &&
               (8 * pose.translation()).array().round().matrix() / 8 == pose.translation();
    });
    if (!exact || !quarter_turns) return {};
    const auto last = static_cast<std::uint32_t>(drawn.scene.size() - 1);
    std::vector<std::size_t> order = all_of(drawn.scene);
    std::ranges::reverse(order);
    const auto reverse_order = results_of(rebuilt(drawn.scene, order), drawn.settings);
    for (const auto& [pair, r] : results[0]) {
        const auto other = reverse_order[0].find({last - pair.second, last - pair.first});
        const Verdict verdict = other == reverse_order[0].end() ? Verdict::separate : other->second.verdict;
        if (verdict != r.verdict)
            return fmt::format("bodies {} and {} in frame 0: {}, but {} in reverse order", pair.first, pair.second,
                               name_of(r.verdict), name_of(verdict));
    }
    return {};
}

/// Calls tried(data) for versions of the geometry with one part removed.
void with_one_part_less(const GeometryData& geometry, const std::function<bool(const GeometryData&)>& tried)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) {
        for (std::size_t t = 0; t < mesh->triangles.size() && mesh->triangles.size() > 1; ++t) {
            auto triangles = mesh->triangles;
            triangles.erase(triangles.begin() + std::ptrdiff_t(t));
            if (tried(make_mesh("mesh", mesh->vertices, triangles))) return;
        }
    } else if (const auto* shape = std::get_if<Shape>(&geometry)) {
        const auto* hull = std::get_if<ConvexHull>(shape);
        for (std::size_t p = 0; hull && p < hull->points.size() && hull->points.size() > 4; ++p) {
            ConvexHull less = *hull;
            less.points.erase(less.points.begin() + std::ptrdiff_t(p));
            if (tried(Shape(less))) return;
        }
    }
}

} // namespace

std::string fault_in(const DrawnScene& drawn)
try {
    std::vector<FrameResults> results;
    const std::string fault = fault_against_truth(drawn, results);
    return fault.empty() ? fault_against_others(drawn, results) : fault;
} catch (const std::exception& error) {
    return fmt::format("error: {}", error.what());
}

FirstFault first_faulty_scene(std::uint64_t first, std::uint64_t count, int threads, const std::function<void()>& done)
{
    std::atomic<std::uint64_t> known = ~std::uint64_t(0); // later scenes are skipped
    const auto run = [&](std::uint64_t seed, FirstFault& found) {
        if (seed >= known) return;
        found.take(seed, fault_in(draw_scene(seed)));
        if (!found.what.empty()) known = std::min(found.seed, known.load());
    };
    return sum_of_seeds<FirstFault>(first, count, threads, run, done);
}

/// Each makes settings plainer.
constexpr void (*plainer_settings[])(Settings&) = {
    [](Settings& s) { s.threads = 1; },
    [](Settings& s) { s.skip = {}; },
    [](Settings& s) { s.coherence = true; },
    [](Settings& s) { s.node_budget = 0; },
    [](Settings& s) { s.memory_budget = 0; },
    [](Settings& s) { s.clearance = 0; },
    [](Settings& s) { s.age_limit = 60; },
    [](Settings& s) { s.contact_kinds = false; },
    [](Settings& s) { s.ignore_touching = false; },
    [](Settings& s) { s.mode = Mode::surface, s.open_as_surface = false; },
    [](Settings& s) { s.bounding_volume = BoundingVolume::automatic; },
    [](Settings& s) { s.broad_phase = BroadPhaseKind::kd_tree; },
    [](Settings& s) { s.depth.reset(), s.max_error.reset(); },
};

DrawnScene shrunk(DrawnScene drawn, const std::function<bool(const DrawnScene&)>& faulty)
{
    const auto keep_if_faulty = [&](DrawnScene smaller) {
        if (!faulty(smaller)) return false;
        drawn = std::move(smaller);
        return true;
    };
    const auto try_scene = [&](const std::vector<std::size_t>& bodies, const BodyChange& change = {}) {
        try {
            return keep_if_faulty({rebuilt(drawn.scene, bodies, change), drawn.settings});
        } catch (const Error&) { // not a valid scene
            return false;
        }
    };
    const auto try_change = [&](std::size_t body, const std::function<void(GeometryData&, BodyInit&)>& change) {
        return try_scene(all_of(drawn.scene), [&](std::size_t i, GeometryData& data, BodyInit& init) {
            if (i == body) change(data, init);
        });
    };
    bool smaller = true;
    while (smaller) {
        smaller = false;
        for (std::size_t i = 0; i < drawn.scene.size() && drawn.scene.size() > 2; ++i) {
            std::vector<std::size_t> bodies = all_of(drawn.scene);
            bodies.erase(bodies.begin() + std::ptrdiff_t(i));
            smaller |= try_scene(bodies);
        }
        for (std::size_t i = 0; i < drawn.scene.size(); ++i) {
            if (drawn.scene.motions[i].index() != 0)
                smaller |= try_change(i, [](GeometryData&, BodyInit& body) { body.motion = Still{}; });
            if (!drawn.scene.start_pose(i).linear().isIdentity(0))
                smaller |= try_change(i, [](GeometryData&, BodyInit& body) { body.pose.linear().setIdentity(); });
            with_one_part_less(data_of(drawn.scene, std::uint32_t(i)), [&](const GeometryData& less) {
                const bool kept = try_change(i, [&](GeometryData& data, BodyInit&) { data = less; });
                smaller |= kept;
                return kept;
            });
        }
        if (drawn.scene.frames > 1) {
            DrawnScene other = drawn;
            other.scene.frames = 1;
            smaller |= keep_if_faulty(std::move(other));
        }
        for (const auto change : plainer_settings) {
            DrawnScene other = drawn;
            change(other.settings);
            if (options_of(other.settings) != options_of(drawn.settings)) smaller |= keep_if_faulty(std::move(other));
        }
    }
    return drawn;
}

std::string options_of(const Settings& s)
{
    std::string text = fmt::format("--exact {} --mode {} --broad {} --bounding-volume {} --threads {} --age {}",
                                   name_of(exact_level(s)), name_of(s.mode), name_of(s.broad_phase),
                                   name_of(s.bounding_volume), s.threads, s.age_limit);
    if (s.depth) text += fmt::format(" --depth {}", *s.depth);
    if (s.max_error) text += fmt::format(" --max-error {}", *s.max_error);
    if (s.clearance > 0) text += fmt::format(" --clearance {:.17g}", s.clearance);
    if (s.contact_kinds) text += " --kinds";
    if (s.ignore_touching) text += " --ignore-touching";
    if (s.mode == Mode::solid && s.open_as_surface) text += " --open-as-surface";
    if (!s.coherence) text += " --no-coherence";
    if (s.node_budget) text += fmt::format(" --node-budget {}", s.node_budget);
    if (s.memory_budget) text += fmt::format(" --memory-budget {}", s.memory_budget);
    for (const std::string& stage : names_of(s.skip)) text += " --skip " + stage;
    return text;
}

} // namespace oncollide::tools
