#include <oncollide/pipeline/mesh_pairs.hpp>

#include <algorithm>

#include <oncollide/base/parallel.hpp>

namespace oncollide {

namespace {

constexpr std::size_t pairs_a_chunk = 64;

Traversal::Nearness within_clearance(Traversal& walk, ObbTree& a, ObbTree& b, const RelativePose& b_to_a,
                                     double clearance)
{
    // Poses may be 2^-20 from rigid: so far may a distance in A's frame be from that in the world.
    constexpr double rigid = 0x1p-18;
    const double farthest = clearance * (1 + 4 * rigid);
    const auto distance = walk.distance(a, b, b_to_a, 0, farthest);
    const double lower = distance.lower * (1 - rigid);
    if (lower > clearance) return {false, lower, {}};
    return {true, distance.upper * (1 + rigid), {}};
}

} // namespace

bool MeshPairs::admit(const Scene& scene, const Frame& frame, BodyPair pair)
{
    return forest_.admit_triangles(scene.geometry[pair.a], frame.number) &&
           forest_.admit_triangles(scene.geometry[pair.b], frame.number);
}

void MeshPairs::make_walks(int threads)
{
    while (walks_.size() < static_cast<std::size_t>(std::max(threads, 1))) walks_.emplace_back();
}

/// answer(walk, geometry a, geometry b, pose, hint, contact) for each ask, on all threads. Asks are sorted by pair, as
/// what met last.
template <class Answer>
void MeshPairs::run(const Scene& scene, Frame& frame, std::span<Ask> asks, Answer answer)
{
    make_walks(frame.threads);
    parallel_chunks(asks.size(), pairs_a_chunk, frame.threads, [&](std::size_t begin, std::size_t end, int thread) {
        auto last = std::lower_bound(met_.begin(), met_.end(), asks[begin].pair,
                                     [](const Met& met, BodyPair pair) { return met.pair < pair; });
        for (Ask& ask : asks.subspan(begin, end - begin)) {
            const auto [a, b] = ask.pair;
            while (last != met_.end() && last->pair < ask.pair) ++last;
            std::optional<TrianglePair> hint;
            if (last != met_.end() && last->pair == ask.pair) hint = last->triangles;
            ask.answer = answer(walks_[static_cast<std::size_t>(thread)], scene.geometry[a], scene.geometry[b],
                                RelativePose(scene.poses[a], scene.poses[b]), hint, ask.contact);
        }
    });
    met_.clear();
    if (frame.settings->coherence)
        for (const Ask& ask : asks)
            if (ask.answer.meeting) met_.push_back({ask.pair, *ask.answer.meeting});
    for (Traversal& walk : walks_) {
        const Traversal::Counts& counts = walk.counts();
        frame.trees.node_pairs += counts.box_rows, frame.trees.triangle_pairs += counts.triangles;
        frame.trees.unsure_pairs += counts.unsure;
        walk.reset_counts();
    }
}

void MeshPairs::near(const Scene& scene, Frame& frame, std::span<Ask> asks)
{
    run(scene, frame, asks,
        [&](Traversal& walk, GeometryId a, GeometryId b, const RelativePose& b_to_a, const auto& hint,
            TriangleContact&) {
            ObbTrees& trees = forest_.obb_trees();
            return walk.near(trees[a], trees[b], b_to_a, frame.settings->clearance, forest_.tolerance(a, b), hint);
        });
}

void MeshPairs::meet(const Scene& scene, Frame& frame, std::span<Ask> asks)
{
    run(scene, frame, asks,
        [&](Traversal& walk, GeometryId a, GeometryId b, const RelativePose& b_to_a, const auto& hint,
            TriangleContact& contact) -> Traversal::Nearness {
            ObbTree &tree_a = forest_.obb_trees()[a], &tree_b = forest_.obb_trees()[b];
            const bool kinds = wants_kinds(*frame.settings);
            const auto meeting = kinds ? walk.contact(tree_a, tree_b, b_to_a, contact, hint)
                                       : walk.first_meeting(tree_a, tree_b, b_to_a, hint);
            const double clearance = frame.settings->clearance;
            if (meeting || clearance == 0) return {meeting.has_value(), 0, meeting};
            return within_clearance(walk, tree_a, tree_b, b_to_a, clearance);
        });
    find_overlaps(scene, frame, asks);
}

bool MeshPairs::closed(const Scene& scene, GeometryId geometry)
{
    closed_.resize(scene.geometries.size());
    std::optional<bool>& known = closed_[index(geometry)];
    if (!known) known = is_closed(std::get<Mesh>(scene.geometries[index(geometry)].data));
    return *known;
}

/// Of closed meshes that touch, and share a point inside all the same: they cross.
void MeshPairs::find_overlaps(const Scene& scene, const Frame& frame, std::span<Ask> asks)
{
    touching_.clear();
    for (Ask& ask : asks)
        if (ask.contact == TriangleContact::touching && closed(scene, scene.geometry[ask.pair.a]) &&
            closed(scene, scene.geometry[ask.pair.b]))
            touching_.push_back(&ask);
    ObbTrees& trees = forest_.obb_trees();
    insides_.resize(walks_.size());
    parallel_chunks(touching_.size(), 1, frame.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (Ask* ask : std::span(touching_).subspan(begin, end - begin)) {
            const auto [a, b] = ask->pair;
            if (insides_[static_cast<std::size_t>(thread)].find(trees[scene.geometry[a]], trees[scene.geometry[b]],
                                                                RelativePose(scene.poses[a], scene.poses[b])))
                ask->contact = TriangleContact::crossing;
        }
    });
}

void MeshPairs::distances(const Scene& scene, const Frame& frame, std::span<const Ask> asks, double tolerance,
                          double farthest, std::vector<Traversal::Distance>& found)
{
    make_walks(frame.threads);
    found.resize(asks.size());
    ObbTrees& trees = forest_.obb_trees();
    parallel_chunks(asks.size(), pairs_a_chunk, frame.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto [a, b] = asks[i].pair;
            found[i] = walks_[static_cast<std::size_t>(thread)].distance(
                trees[scene.geometry[a]], trees[scene.geometry[b]], RelativePose(scene.poses[a], scene.poses[b]),
                tolerance, farthest);
        }
    });
}

} // namespace oncollide
