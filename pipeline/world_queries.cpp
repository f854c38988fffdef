// World: const queries, safe from many threads.
#include <oncollide/pipeline/world_impl.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/pipeline/refine/placed_pair.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

namespace {

/// A query for bodies that meet a model at a pose.
struct Probe {
    Model* model;
    Eigen::Isometry3d pose;
    QueryFilter filter;
    const Aabb* solid_box = nullptr; ///< bodies wholly inside this box are hits, too
};

bool allows(const QueryFilter& q, const Bodies& bodies, std::uint32_t slot)
{
    return (q.layer & bodies.mask(slot)) && (bodies.layer(slot) & q.mask) &&
           (q.group == 0 || q.group != bodies.group(slot));
}

/// True if some part of the body has a point in the box.
bool has_point_in(const Bodies& bodies, std::uint32_t slot, const Aabb& box)
{
    const RelativePose into(bodies.pose(slot), Eigen::Isometry3d::Identity());
    return bodies.model(slot).any_part(box, into, [&](const PartPoints& part) {
        const Eigen::Vector3d point = bodies.pose(slot) * part[0];
        return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
    });
}

} // namespace

World::Impl::QueryWorker::QueryWorker(Impl& impl)
    : levels(impl.settings, impl.models), context{.settings = impl.settings,
                                                  .trees = {},
                                                  .rounds = {},
                                                  .began = {},
                                                  .guard = &impl.guard}
{
}

/// Lends a worker to one call.
class World::Impl::Lease {
public:
    explicit Lease(Impl& impl) : impl_(impl)
    {
        {
            const std::lock_guard lock(impl.idle_guard);
            if (!impl.idle_workers.empty()) worker_ = std::move(impl.idle_workers.back()), impl.idle_workers.pop_back();
        }
        if (!worker_) worker_ = std::make_unique<QueryWorker>(impl);
        worker_->context.frame = impl.frame.number;
        worker_->context.trees = {}, worker_->context.rounds.clear();
    }
    ~Lease()
    {
        const std::lock_guard lock(impl_.idle_guard);
        impl_.idle_workers.push_back(std::move(worker_));
    }
    QueryWorker* operator->() { return worker_.get(); }
    QueryWorker& operator*() { return *worker_; }

    /// Appends the hits of `probe`.
    void run(const Probe& probe, std::vector<QueryHit>& hits)
    {
        QueryWorker& w = *worker_;
        const Bodies& bodies = impl_.bodies;
        w.boxes.assign(1, probe.model->bounds().box(probe.pose));
        impl_.broad->query(bodies.columns(), w.boxes, w.hits);
        w.tasks.clear(), w.refined.clear();
        for (const BoxHit& hit : w.hits) {
            if (!allows(probe.filter, bodies, hit.body)) continue;
            w.tasks.push_back({hit.body, probe.model, &bodies.model(hit.body), &probe.pose, &bodies.pose(hit.body)});
            w.refined.push_back(
                {Verdict::undecided, ContactKind::unknown, farthest_apart(w.boxes.front(), bodies.boxes()[hit.body])});
        }
        w.levels.run(w.context, w.tasks, w.refined);
        for (std::size_t i = 0; i < w.tasks.size(); ++i) {
            const std::uint32_t slot = w.tasks[i].number;
            RefineResult& result = w.refined[i];
            if (probe.solid_box && result.verdict != Verdict::colliding) look_inside(probe, slot, result);
            if (result.verdict != Verdict::separate)
                hits.push_back({bodies.id(slot), result.verdict, result.kind, result.bound});
        }
    }

private:
    /// Detects parts of the body inside the box, where surfaces do not meet.
    void look_inside(const Probe& probe, std::uint32_t slot, RefineResult& result)
    {
        try {
            if (impl_.models.with_room([&] { return has_point_in(impl_.bodies, slot, *probe.solid_box); }))
                result = {Verdict::colliding, ContactKind::enclosed, 0};
        } catch (const ChunkFault& fault) {
            impl_.models.note(fault.what());
            result = {Verdict::undecided, ContactKind::unknown,
                      farthest_apart(worker_->boxes.front(), impl_.bodies.boxes()[slot])};
        }
    }

    Impl& impl_;
    std::unique_ptr<QueryWorker> worker_;
};

/// Calls work(worker, item, found) for each item on the World's threads, where `work` appends to `found`; ends[i] is
/// the end of item i's results in `found`. Overwrites both.
template <class Found, class Item, class Work>
void World::Impl::in_parts(std::span<const Item> items, std::size_t chunk, std::vector<Found>& found,
                           std::vector<std::size_t>& ends, Work work)
{
    found.clear(), ends.clear();
    if (frame.context.threads == 1) { // avoids copies
        Lease worker(*this);
        for (const Item& item : items) {
            work(worker, item, found);
            ends.push_back(found.size());
        }
        return;
    }
    struct Part {
        std::vector<Found> found;
        std::vector<std::size_t> ends;
    };
    std::vector<Part> parts((items.size() + chunk - 1) / chunk);
    const ExecutorScope scope(settings.executor);
    parallel_chunks(parts.size(), 1, frame.context.threads, [&](std::size_t begin, std::size_t end, int) {
        Lease worker(*this);
        for (std::size_t i = begin; i < end; ++i)
            for (const Item& item : items.subspan(i * chunk, std::min(chunk, items.size() - i * chunk))) {
                work(worker, item, parts[i].found);
                parts[i].ends.push_back(parts[i].found.size());
            }
    });
    for (const Part& part : parts) {
        for (std::size_t end : part.ends) ends.push_back(found.size() + end);
        found.insert(found.end(), part.found.begin(), part.found.end());
    }
}

namespace {

/// A transient model, for one query.
class TransientModel {
public:
    TransientModel(ModelStore& models, std::shared_mutex& guard, Mesh mesh) : models_(models), guard_(guard)
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
    std::shared_mutex& guard_;
    Model* model_;
};

Mesh box_mesh(const Aabb& box)
{
    std::vector<Eigen::Vector3d> corners;
    for (unsigned k = 0; k < 8; ++k) corners.push_back(corner_of(box, k));
    return make_mesh("box", std::move(corners), {box_faces.begin(), box_faces.end()});
}

} // namespace

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
    Model& mine = impl_->model_of(model);
    impl_->check_pose(std::nullopt, pose);
    impl_->bring_up_to_date();
    std::vector<QueryHit> hits;
    Impl::Lease(*impl_).run({&mine, pose, filter}, hits);
    return hits;
}

void World::query(std::span<const ModelQuery> queries, QueryHits& out) const
{
    Impl& p = *impl_;
    for (const ModelQuery& query : queries) p.model_of(query.model), p.check_pose(std::nullopt, query.pose);
    p.bring_up_to_date();
    p.in_parts<QueryHit>(queries, 64, out.hits, out.ends, [&](auto& worker, const ModelQuery& query, auto& hits) {
        worker.run({&p.models[query.model], query.pose, query.filter}, hits);
    });
}

std::vector<QueryHit> World::query(const Segment& segment, const QueryFilter& filter) const
{
    Mesh mesh = make_mesh("segment", {segment.from, segment.to}, {{0, 1, 1}});
    impl_->bring_up_to_date();
    TransientModel model(impl_->models, impl_->guard, std::move(mesh));
    std::vector<QueryHit> hits;
    Impl::Lease(*impl_).run({&*model, Eigen::Isometry3d::Identity(), filter}, hits);
    return hits;
}

std::vector<QueryHit> World::query(const Aabb& box, const QueryFilter& filter) const
{
    if (box.empty()) throw Error(ErrorKind::bad_data, "query: the box is empty (min > max)");
    Mesh mesh = box_mesh(box);
    impl_->bring_up_to_date();
    TransientModel model(impl_->models, impl_->guard, std::move(mesh));
    std::vector<QueryHit> hits;
    Impl::Lease(*impl_).run({&*model, Eigen::Isometry3d::Identity(), filter, &box}, hits);
    return hits;
}

/// Makes the OBB tree for finding contacts, unless the model has no triangles and makes its own data on demand.
void World::Impl::need_tree(Model& model)
{
    if (!model.has_triangles()) return;
    const std::lock_guard lock(guard);
    models.obb_tree(model, frame.number);
}

std::vector<Contact> World::contacts(BodyId a, BodyId b) const
{
    ContactLists lists;
    const PairOfBodies pair{a, b};
    contacts({&pair, 1}, lists);
    return std::move(lists.contacts);
}

void World::contacts(std::span<const PairOfBodies> pairs, ContactLists& lists) const
{
    Impl& p = *impl_;
    for (const PairOfBodies& pair : pairs)
        for (const BodyId body : {pair.a, pair.b}) p.need_tree(p.bodies.model(p.slot_of(body)));
    p.in_parts<Contact>(
        pairs, 16, lists.contacts, lists.ends, [&](auto& worker, const PairOfBodies& pair, auto& found) {
            const PairTask task = p.task_of(pair.a.slot, pair.b.slot);
            const auto has_surface = [](const Model& model) { return model.is_mesh() || model.terrain(); };
            p.models.with_room([&, begin = found.size()] {
                found.resize(begin);
                if (has_surface(*task.a) && has_surface(*task.b))
                    worker->contacts.find(*task.a, *task.pose_a, *task.b, *task.pose_b, found);
                else
                    worker->solid_contacts.find(task, found);
            });
        });
}

void World::penetration(std::span<const PairOfBodies> pairs, std::span<Penetration> found) const
{
    Impl& p = *impl_;
    if (pairs.size() != found.size())
        throw Error(ErrorKind::usage, fmt::format("penetration: spans of {} and {} elements; must have the same length",
                                                  pairs.size(), found.size()));
    for (const PairOfBodies& pair : pairs)
        for (const BodyId body : {pair.a, pair.b}) {
            Model& model = p.bodies.model(p.slot_of(body));
            if (!model.has_triangles())
                throw Error(ErrorKind::usage,
                            fmt::format("penetration: {} is not a mesh, box or hull", p.label(body.slot)));
            if (model.cooked() && reads_on_demand(p.settings))
                throw Error(ErrorKind::usage,
                            fmt::format("penetration: {} is a cooked mesh that is read on demand; penetration needs "
                                        "the whole mesh, as returned by load_mesh()",
                                        p.label(body.slot)));
            p.need_tree(model);
        }
    const ExecutorScope scope(p.settings.executor);
    parallel_chunks(pairs.size(), 4, p.frame.context.threads, [&](std::size_t begin, std::size_t end, int) {
        Impl::Lease worker(p);
        for (std::size_t i = begin; i < end; ++i) {
            const PairTask task = p.task_of(pairs[i].a.slot, pairs[i].b.slot);
            worker->meetings.clear();
            worker->contacts.find(*task.a->obb_tree, *task.pose_a, *task.b->obb_tree, *task.pose_b, worker->meetings);
            found[i] = worker->penetration.measure(task, worker->meetings);
        }
    });
}

Distance World::distance(BodyId body_a, BodyId body_b, double tolerance, double farthest) const
{
    Impl& p = *impl_;
    check_distance(tolerance, farthest);
    const PairTask task = p.task_of(p.slot_of(body_a), p.slot_of(body_b));
    if (task.a->shape() && task.b->shape()) // needs no worker and no tree
        return DirectPair(task).distance({.above = farthest, .tolerance = tolerance});
    for (Model* model : {task.a, task.b}) p.need_tree(*model);
    Impl::Lease worker(p);
    return p.models.with_room([&] { return worker->distances.find(task, p.settings.mode, tolerance, farthest); });
}

} // namespace oncollide
