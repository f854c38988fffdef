// World: const queries of one thing against all bodies, safe from many threads at once.
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/pipeline/check_distance.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

namespace {

/// True if some point of the body lies in the box.
bool has_point_in(const Bodies& bodies, std::uint32_t slot, const Aabb& box)
{
    const RelativePose into(bodies.pose(slot));
    return bodies.model(slot).any_part(box, into, [&](const PartPoints& part) {
        const Eigen::Vector3d point = bodies.pose(slot) * part[0];
        return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
    });
}

/// A model that lives as long as one query.
class TransientModel {
public:
    TransientModel(ModelStore& models, WorldMutex& guard, Mesh mesh) : models_(models), guard_(guard)
    {
        auto geometry = std::make_shared<const Geometry>(Geometry{{}, std::move(mesh), {}});
        const std::lock_guard lock(guard);
        model_ = &models.add_transient(std::move(geometry));
    }
    ~TransientModel()
    {
        const std::lock_guard lock(guard_);
        models_.remove_transient(*model_);
    }
    TransientModel(const TransientModel&) = delete;
    TransientModel& operator=(const TransientModel&) = delete;
    Model& operator*() { return *model_; }

private:
    ModelStore& models_;
    WorldMutex& guard_;
    Model* model_;
};

Mesh box_mesh(const Aabb& box)
{
    std::vector<Eigen::Vector3d> corners;
    for (unsigned k = 0; k < 8; ++k) corners.push_back(corner_of(box, k));
    return make_mesh("box", std::move(corners), {box_faces.begin(), box_faces.end()});
}

} // namespace

void check_ends(const char* call, std::span<const Segment> segments)
{
    for (std::size_t i = 0; i < segments.size(); ++i)
        for (const Eigen::Vector3d& end : {segments[i].from, segments[i].to})
            if (!(end.cwiseAbs().sum() <= 1e15) && (!(end.cwiseAbs().maxCoeff() <= 1e15) || !end.allFinite()))
                throw Error(ErrorKind::bad_data,
                            fmt::format("{} {}: a point of the segment is not finite, or beyond 1e15 m", call, i));
}

bool World::Impl::allows(const QueryFilter& q, std::uint32_t slot) const
{
    return (q.layer & bodies.mask(slot)) && (bodies.layer(slot) & q.mask) &&
           (q.group == 0 || q.group != bodies.group(slot));
}

/// A model at a pose, as a query tests it.
struct World::Impl::Probe {
    Model* model;
    Eigen::Isometry3d pose;
    QueryFilter filter;
    const Aabb* solid_box = nullptr; ///< bodies wholly inside are hits, too
};

/// Leaves in worker.tasks the bodies that the filter allows and whose AABBs are at most `margin` from the probe's.
void World::Impl::find_near(QueryWorker& worker, const Probe& probe, double margin)
{
    worker.boxes.assign(1, grown(probe.model->bounds().box(probe.pose), margin));
    broad->query(bodies.columns(), worker.boxes, worker.hits);
    worker.tasks.clear();
    for (const AabbHit& hit : worker.hits)
        if (allows(probe.filter, hit.body))
            worker.tasks.push_back(
                {hit.body, probe.model, &bodies.model(hit.body), &probe.pose, &bodies.pose(hit.body)});
}

/// Appends the hits of `probe` among worker.tasks.
void World::Impl::refine_hits(QueryWorker& w, const Probe& probe, std::vector<QueryHit>& hits)
{
    constexpr double unknown = std::numeric_limits<double>::infinity();
    const auto farthest = [&](std::uint32_t slot) {
        return farthest_apart(probe.model->bounds().box(probe.pose), bodies.boxes()[slot]);
    };
    w.refined.assign(w.tasks.size(), {Verdict::undecided, ContactKind::unknown, unknown});
    w.levels.run(w.context, w.tasks, w.refined);
    for (std::size_t i = 0; i < w.tasks.size(); ++i) {
        const std::uint32_t slot = w.tasks[i].number;
        Finding& found = w.refined[i];
        if (probe.solid_box && found.verdict != Verdict::colliding) // parts of the body whose surface meets no face
            try {
                if (models.with_room([&] { return has_point_in(bodies, slot, *probe.solid_box); }))
                    found = {Verdict::colliding, ContactKind::enclosed, 0};
            } catch (const ChunkFault& fault) {
                models.note(fault.what());
                found = {Verdict::undecided, ContactKind::unknown, farthest(slot)};
            }
        if (found.verdict == Verdict::separate) continue;
        if (found.bound == unknown) found.bound = farthest(slot); // no level had room or time
        hits.push_back({found, bodies.id(slot)});
    }
}

void World::Impl::find_hits(QueryWorker& w, const Probe& probe, std::vector<QueryHit>& hits)
{
    find_near(w, probe, 0);
    if (!w.tasks.empty()) refine_hits(w, probe, hits);
}

/// True if the body has the tree that segments need, or needs none. Makes the tree if there is room.
bool World::Impl::has_tree_for_segments(std::uint32_t slot)
{
    Model& model = bodies.model(slot);
    if (with_tree.load(std::memory_order_acquire) == &model || !SegmentQuery::needs_tree(model.kind())) return true;
    model.need_obb_tree(frame.number);
    bool has;
    {
        const std::shared_lock lock(guard);
        has = model.has_obb_tree();
    }
    if (!has) {
        const std::lock_guard lock(guard);
        has = models.admit_obb_tree(model, frame.number);
    }
    if (has) with_tree.store(&model, std::memory_order_release);
    return has;
}

/// True if on_segment() covers the body. Makes the tree that it needs.
bool World::Impl::tests_segments(std::uint32_t slot)
{
    return SegmentQuery::covers(bodies.model(slot).kind()) && has_tree_for_segments(slot);
}

/// The result of a segment and a body, in the body's frame.
Finding World::Impl::on_segment(QueryWorker& w, std::uint32_t slot, const Segment& segment)
{
    Model& model = bodies.model(slot);
    const RelativePose into(bodies.pose(slot));
    const Segment mine{into(segment.from), into(segment.to)};
    try {
        return models.with_room([&] { return w.segments.decide(model, mine, settings.mode == Mode::solid); });
    } catch (const ChunkFault& fault) {
        models.note(fault.what());
        Aabb box;
        box.add(segment.from), box.add(segment.to);
        return {Verdict::undecided, ContactKind::unknown, farthest_apart(box, bodies.boxes()[slot])};
    }
}

/// Appends the hits of a segment. on_segment() decides hits alone; where the settings require more, or the model's kind
/// is not covered, the tests of pairs decide, with a triangle of the segment's shape.
/// Leaves in worker.hits the bodies in whose AABBs the segment may be. Few bodies need no search, and a single one that
/// is tested exactly no test of its AABB.
void World::Impl::find_boxes(QueryWorker& w, const Segment& segment)
{
    constexpr std::uint32_t few = 4;
    if (bodies.slots() > few) return broad->query_segments(bodies.columns(), std::span(&segment, 1), w.hits);
    w.hits.clear();
    for (std::uint32_t slot = 0; slot < bodies.slots(); ++slot)
        if (bodies.alive(slot) && ((bodies.slots() == 1 && SegmentQuery::covers(bodies.model(slot).kind())) ||
                                   part_in(segment, bodies.boxes()[slot])))
            w.hits.push_back({0, slot});
}

void World::Impl::find_hits(QueryWorker& w, const Segment& segment, const QueryFilter& filter,
                            std::vector<QueryHit>& hits)
{
    const bool plain = settings.clearance == 0 && !wants_kinds(settings);
    if (plain)
        find_boxes(w, segment);
    else
        broad->query_segments(bodies.columns(), std::span(&segment, 1), w.hits);
    const std::size_t first = hits.size();
    w.tasks.clear();
    for (const AabbHit& hit : w.hits) {
        if (!allows(filter, hit.body)) continue;
        if (!plain || !tests_segments(hit.body))
            w.tasks.push_back({hit.body, nullptr, &bodies.model(hit.body), nullptr, &bodies.pose(hit.body)});
        else if (const Finding found = on_segment(w, hit.body, segment); found.verdict != Verdict::separate)
            hits.push_back({found, bodies.id(hit.body)});
    }
    if (w.tasks.empty()) return;
    TransientModel model(models, guard, make_mesh("segment", {segment.from, segment.to}, {{0, 1, 1}}));
    const Probe probe{&*model, Eigen::Isometry3d::Identity(), filter};
    for (PairTask& task : w.tasks) task.a = probe.model, task.pose_a = &probe.pose;
    refine_hits(w, probe, hits);
    std::ranges::sort(hits.begin() + static_cast<std::ptrdiff_t>(first), hits.end(), {},
                      [](const QueryHit& hit) { return hit.body.slot; });
}

void World::Impl::bring_up_to_date()
{
    if (taken_in.load(std::memory_order_acquire)) return;
    const std::lock_guard lock(guard);
    if (taken_in.load(std::memory_order_relaxed)) return;
    const ExecutorScope scope(settings.executor);
    take_in_changes();
    update_boxes(bodies, frame.changes, true, frame.context.threads);
    broad->take_in(bodies.columns());
    taken_in.store(true, std::memory_order_release);
}

std::vector<QueryHit> World::query(ModelId model, const Eigen::Isometry3d& pose, const QueryFilter& filter) const
{
    Impl& p = impl();
    Model& mine = p.check_model(model);
    p.check_pose("", pose);
    p.bring_up_to_date();
    std::vector<QueryHit> hits;
    Impl::Lease worker(p);
    p.find_hits(*worker, {&mine, pose, filter}, hits);
    return hits;
}

void World::query(std::span<const ModelQuery> queries, QueryHits& out) const
{
    Impl& p = impl();
    for (std::size_t i = 0; i < queries.size(); ++i)
        naming("query", i, nullptr, [&] { p.check_model(queries[i].model), p.check_pose("", queries[i].pose); });
    p.bring_up_to_date();
    p.gather(queries.size(), 64, out.hits, out.offsets, [&](auto& worker, std::size_t i, auto& hits) {
        const ModelQuery& query = queries[i];
        p.find_hits(worker, {&p.models[query.model], query.pose, query.filter}, hits);
    });
}

void World::near(std::span<const ModelQuery> queries, std::span<const double> reaches, QueryHits& out) const
{
    Impl& p = impl();
    same_room("near", "queries", queries.size(), "reaches", reaches.size());
    check_reaches("near: reach", reaches);
    for (std::size_t i = 0; i < queries.size(); ++i)
        naming("near", i, nullptr, [&] { p.check_model(queries[i].model), p.check_pose("", queries[i].pose); });
    p.bring_up_to_date();
    p.gather(queries.size(), 64, out.hits, out.offsets, [&](auto& worker, std::size_t i, auto& hits) {
        const ModelQuery& query = queries[i];
        p.find_near(worker, {&p.models[query.model], query.pose, query.filter}, reaches[i] * (1 + 0x1p-40));
        p.need_trees(worker.tasks);
        for (const PairTask& task : worker.tasks)
            if (p.may_be_near(worker, task, reaches[i])) hits.push_back({Finding{}, p.bodies.id(task.number)});
    });
}

std::vector<QueryHit> World::query(const Segment& segment, const QueryFilter& filter) const
{
    Impl& p = impl();
    check_ends("query", std::span(&segment, 1));
    p.bring_up_to_date();
    std::vector<QueryHit> hits;
    Impl::Lease worker(p);
    p.find_hits(*worker, segment, filter, hits);
    return hits;
}

void World::query(std::span<const Segment> segments, const QueryFilter& filter, QueryHits& out) const
{
    Impl& p = impl();
    check_ends("query", segments);
    p.bring_up_to_date();
    p.gather(segments.size(), 64, out.hits, out.offsets,
             [&](auto& worker, std::size_t i, auto& hits) { p.find_hits(worker, segments[i], filter, hits); });
}

std::vector<QueryHit> World::query(const Aabb& box, const QueryFilter& filter) const
{
    Impl& p = impl();
    if (box.empty()) throw Error(ErrorKind::bad_data, "query: the box is empty (min > max)");
    Mesh mesh = box_mesh(box);
    p.bring_up_to_date();
    TransientModel model(p.models, p.guard, std::move(mesh));
    std::vector<QueryHit> hits;
    Impl::Lease worker(p);
    p.find_hits(*worker, {&*model, Eigen::Isometry3d::Identity(), filter, &box}, hits);
    return hits;
}

std::vector<BodyDistance> World::distances(const ModelQuery& query, double cutoff, double tolerance) const
{
    Impl& p = impl();
    check_distance(tolerance, cutoff);
    if (!std::isfinite(cutoff)) throw Error(ErrorKind::usage, "distances: the cutoff to all bodies must be finite");
    Model& mine = p.check_model(query.model);
    p.check_pose("", query.pose);
    p.bring_up_to_date();
    Impl::Lease worker(p);
    p.find_near(*worker, {&mine, query.pose, query.filter}, cutoff * (1 + 0x1p-40));
    for (PairTask& task : worker->tasks) task.pose_a = &query.pose; // the probe is gone
    p.need_trees(worker->tasks);
    std::vector<BodyDistance> found;
    for (const PairTask& task : worker->tasks)
        if (const Distance distance = p.distance(*worker, task, tolerance, cutoff); distance.lower <= cutoff)
            found.push_back({p.bodies.id(task.number), distance});
    return found;
}

} // namespace oncollide
