// Space: queries of one thing against all bodies, safe from many threads at once.
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

namespace {

/// True if some point of the body lies in the box.
bool has_point_in(const BodyTable& bodies, std::uint32_t slot, const Aabb& box)
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

bool WorldImpl::allows(const CollisionFilter& q, std::uint32_t slot) const
{
    return (q.layer & bodies.mask(slot)) && (bodies.layer(slot) & q.mask) &&
           (q.group == 0 || q.group != bodies.group(slot));
}

void WorldImpl::check_placed(const char* call, std::size_t number, const PlacedModel& placed)
{
    naming(call, number, nullptr, [&] { check_model(placed.model), check_pose("", placed.pose); });
}

/// A model at a pose, as a query tests it.
struct WorldImpl::Probe {
    Model* model;
    Eigen::Isometry3d pose;
    CollisionFilter filter;
    const Aabb* solid_box = nullptr; ///< bodies wholly inside are hits, too
};

/// Leaves in worker.tasks the bodies that the filter allows and whose AABBs are at most `margin` from the probe's.
void WorldImpl::find_near(QueryWorker& worker, const Probe& probe, double margin)
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
void WorldImpl::refine_hits(QueryWorker& w, const Probe& probe, std::vector<QueryHit>& hits)
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
        // A part of the body whose surface meets no face of the box may be inside it.
        if (probe.solid_box && found.verdict != Verdict::colliding) try {
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

void WorldImpl::find_hits(QueryWorker& w, const Probe& probe, std::vector<QueryHit>& hits)
{
    find_near(w, probe, 0);
    if (!w.tasks.empty()) refine_hits(w, probe, hits);
}

/// True if the body has the tree that segments need, or needs none. Makes the tree if there is room.
bool WorldImpl::has_tree_for_segments(std::uint32_t slot)
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
bool WorldImpl::tests_segments(std::uint32_t slot)
{
    return SegmentQuery::covers(bodies.model(slot).kind()) && has_tree_for_segments(slot);
}

/// The result of a segment and a body, in the body's frame.
Finding WorldImpl::on_segment(QueryWorker& w, std::uint32_t slot, const Segment& segment)
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
/// is not covered, the tests of pairs decide, with a triangle of the segment's shape. Leaves in worker.hits the bodies
/// in whose AABBs the segment may be. Few bodies need no search, and a single body that is tested exactly needs no test
/// of its AABB.
void WorldImpl::find_boxes(QueryWorker& w, const Segment& segment)
{
    constexpr std::uint32_t few = 4;
    if (bodies.slots() > few) return broad->query_segments(bodies.columns(), std::span(&segment, 1), w.hits);
    w.hits.clear();
    for (std::uint32_t slot = 0; slot < bodies.slots(); ++slot)
        if (bodies.alive(slot) && ((bodies.slots() == 1 && SegmentQuery::covers(bodies.model(slot).kind())) ||
                                   part_in(segment, bodies.boxes()[slot])))
            w.hits.push_back({0, slot});
}

void WorldImpl::find_hits(QueryWorker& w, const Segment& segment, const CollisionFilter& filter,
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

void WorldImpl::bring_up_to_date()
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

std::vector<QueryHit> Space::overlaps(const PlacedModel& model, const CollisionFilter& filter) const
{
    WorldImpl& p = *world_;
    Model& mine = p.check_model(model.model);
    p.check_pose("", model.pose);
    p.bring_up_to_date();
    std::vector<QueryHit> hits;
    WorldImpl::Lease worker(p);
    p.find_hits(*worker, {&mine, model.pose, filter}, hits);
    return hits;
}

void Space::overlaps(std::span<const PlacedModel> models, const CollisionFilter& filter, Lists<QueryHit>& out) const
{
    WorldImpl& p = *world_;
    for (std::size_t i = 0; i < models.size(); ++i) p.check_placed("overlaps", i, models[i]);
    p.bring_up_to_date();
    p.gather(models.size(), 64, out, [&](auto& worker, std::size_t i, auto& hits) {
        p.find_hits(worker, {&p.models[models[i].model], models[i].pose, filter}, hits);
    });
}

std::vector<QueryHit> Space::overlaps(const Segment& segment, const CollisionFilter& filter) const
{
    WorldImpl& p = *world_;
    check_ends("overlaps", std::span(&segment, 1));
    p.bring_up_to_date();
    std::vector<QueryHit> hits;
    WorldImpl::Lease worker(p);
    p.find_hits(*worker, segment, filter, hits);
    return hits;
}

void Space::overlaps(std::span<const Segment> segments, const CollisionFilter& filter, Lists<QueryHit>& out) const
{
    WorldImpl& p = *world_;
    check_ends("overlaps", segments);
    p.bring_up_to_date();
    p.gather(segments.size(), 64, out,
             [&](auto& worker, std::size_t i, auto& hits) { p.find_hits(worker, segments[i], filter, hits); });
}

std::vector<QueryHit> Space::overlaps(const Aabb& box, const CollisionFilter& filter) const
{
    Lists<QueryHit> hits;
    overlaps(std::span(&box, 1), filter, hits);
    return std::move(hits.items);
}

void Space::overlaps(std::span<const Aabb> boxes, const CollisionFilter& filter, Lists<QueryHit>& out) const
{
    WorldImpl& p = *world_;
    std::vector<Mesh> meshes;
    for (std::size_t i = 0; i < boxes.size(); ++i)
        naming("overlaps", i, nullptr, [&] {
            if (boxes[i].empty()) throw Error(ErrorKind::bad_data, "the box is empty (min > max)");
            meshes.push_back(box_mesh(boxes[i]));
        });
    p.bring_up_to_date();
    p.gather(boxes.size(), 16, out, [&](auto& worker, std::size_t i, auto& hits) {
        TransientModel model(p.models, p.guard, std::move(meshes[i]));
        p.find_hits(worker, {&*model, Eigen::Isometry3d::Identity(), filter, &boxes[i]}, hits);
    });
}

std::vector<BodyDistance> Space::distances(const PlacedModel& model, const CollisionFilter& filter,
                                           const DistanceOptions& options) const
{
    Lists<BodyDistance> found;
    distances(std::span(&model, 1), filter, options, found);
    return std::move(found.items);
}

void Space::distances(std::span<const PlacedModel> models, const CollisionFilter& filter,
                      const DistanceOptions& options, Lists<BodyDistance>& out) const
{
    WorldImpl& p = *world_;
    check_distance(options);
    if (!std::isfinite(options.cutoff))
        throw Error(ErrorKind::usage, "distances: the cutoff to all bodies must be finite");
    for (std::size_t i = 0; i < models.size(); ++i) p.check_placed("distances", i, models[i]);
    p.bring_up_to_date();
    p.gather(models.size(), 4, out, [&](auto& worker, std::size_t i, auto& found) {
        const PlacedModel& model = models[i];
        p.find_near(worker, {&p.models[model.model], model.pose, filter}, options.cutoff * (1 + 0x1p-40));
        for (PairTask& task : worker.tasks) task.pose_a = &model.pose; // the probe is gone
        p.need_trees(worker.tasks);
        for (const PairTask& task : worker.tasks)
            if (const Distance distance = p.distance(worker, task, options); distance.lower <= options.cutoff)
                found.push_back({p.bodies.id(task.number), distance});
    });
}

} // namespace oncollide
