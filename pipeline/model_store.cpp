#include <oncollide/pipeline/model_store.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace oncollide {

ModelStore::ModelStore(const Settings& settings, std::unique_ptr<OcclusionBackend> backend, std::uint16_t world)
    : settings_(settings), world_(world), backend_(std::move(backend)), chunks_(settings.resident_budget)
{
}

Model& ModelStore::by_number(std::uint32_t number) const
{
    return number % 2 ? *passing_[number / 2] : *slots_[number / 2].model;
}

std::unique_ptr<Model> ModelStore::make_model(std::shared_ptr<const Geometry> geometry, std::uint32_t number)
{
    auto model = std::make_unique<Model>(std::move(geometry));
    model->number = number;
    if (reads_on_demand(settings_)) model->read_on_demand(chunks_);
    if (model->terrain() || (model->file() && model->map())) grids_.push_back(model.get());
    return model;
}

ModelId ModelStore::add(std::shared_ptr<const Geometry> geometry)
{
    if (free_.empty()) free_.push_back(static_cast<std::uint32_t>(slots_.size())), slots_.emplace_back();
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    slots_[slot].model = make_model(std::move(geometry), 2 * slot);
    ++size_;
    return id(slot);
}

void ModelStore::drop(Model& model)
{
    const Prefetcher::Pause pause(ahead_.get());
    if (ahead_) ahead_->forget(model);
    drop_prepared(&model, 0, 0);
    drop_spheres(model.number);
    if (drop_obb_tree(model)) std::erase(with_obb_trees_, &model);
    std::erase(grids_, &model);
}

void ModelStore::replace(ModelId id, std::shared_ptr<const Geometry> geometry)
{
    Slot& slot = slots_[id.slot];
    drop(*slot.model);
    if (geometry != slot.own) slot.own.reset();
    slot.model = make_model(std::move(geometry), 2 * id.slot);
}

std::shared_ptr<Geometry> ModelStore::own(ModelId id)
{
    Slot& slot = slots_[id.slot];
    if (!slot.own) slot.own = std::make_shared<Geometry>(slot.model->geometry());
    return slot.own;
}

void ModelStore::remove(ModelId id)
{
    drop(*slots_[id.slot].model);
    slots_[id.slot].model.reset(), slots_[id.slot].own.reset();
    if (slots_[id.slot].generation++ < last_generation) free_.push_back(id.slot);
    --size_;
}

Model& ModelStore::add_transient(std::shared_ptr<const Geometry> geometry)
{
    const auto free = std::find(passing_.begin(), passing_.end(), nullptr);
    auto model = make_model(std::move(geometry), 2 * static_cast<std::uint32_t>(free - passing_.begin()) + 1);
    return **(free == passing_.end() ? passing_.insert(free, std::move(model)) : (*free = std::move(model), free));
}

void ModelStore::remove_transient(Model& model)
{
    drop(model);
    passing_[model.number / 2].reset();
}

double ModelStore::max_error(const Model& a, const Model& b) const
{
    if (settings_.max_error) return *settings_.max_error;
    const double of_a = a.bounds().diagonal(), of_b = b.bounds().diagonal();
    return settings_.depth ? std::ldexp(of_a + of_b, -*settings_.depth) : default_error * std::min(of_a, of_b);
}

int ModelStore::depth(const Model& model, double max_error) const
{
    if (settings_.depth) return *settings_.depth;
    const Ocst& tree = *model.spheres;
    // Rounding in the traversal (see make_plan) is below 2^-15 of the two root radii for bodies that touch.
    const double rounding = 4 * tree.radius(0) * 0x1p-15;
    int depth = 1;
    while (depth < deepest_level && 4 * tree.radius(depth) + 2 * tree.error(depth) + rounding > max_error) ++depth;
    return depth;
}

Ocst& ModelStore::spheres(Model& model, double max_error)
{
    if (!model.spheres) {
        model.spheres = std::make_unique<Ocst>(model.root_cell(), 1, model.covering_error());
        model.spheres->admit_backend(*backend_);
        with_spheres_.push_back(model.number);
    }
    model.spheres->deepen(depth(model, max_error));
    return *model.spheres;
}

ModelStore::Room ModelStore::all_grown(const Model& model)
{
    Room room;
    room.nodes = ObbTree::most_nodes(model.triangles()), room.bytes = ObbTree::most_bytes(model.triangles());
    return room;
}

bool ModelStore::admit_obb_tree(Model& model, std::uint32_t frame)
{
    if (model.obb_tree_used.load(std::memory_order_relaxed) != frame) model.obb_tree_used = frame;
    if (model.obb_tree) return true;
    if (model.map()) return model.cells(), true;
    if (model.terrain()) return model.heights(), true;
    if (!model.has_triangles()) return true;
    const auto left = [](auto budget, auto held) -> decltype(budget) {
        if (budget == 0) return std::numeric_limits<decltype(budget)>::max();
        return budget > held ? budget - held : 0;
    };
    const Room more = all_grown(model);
    if (more.nodes > left(std::uint64_t(settings_.node_budget), cells() + reserved_.nodes) ||
        more.bytes > left(settings_.memory_budget, sphere_bytes() + reserved_.bytes))
        return false;
    if (!model.unreadable.empty()) return false;
    try {
        make_obb_tree(model, more);
    } catch (const ChunkFault& fault) {
        model.unreadable = fault.what();
        return false;
    }
    return true;
}

ObbTree& ModelStore::obb_tree(Model& model, std::uint32_t frame)
{
    model.obb_tree_used = frame;
    if (!model.obb_tree) make_obb_tree(model, all_grown(model));
    return *model.obb_tree;
}

void ModelStore::make_obb_tree(Model& model, const Room& room)
{
    const auto make = [&] { model.make_obb_tree(reads_on_demand(settings_) ? &chunks_ : nullptr, boxes_); };
    if (!ahead_) {
        make();
    } else {
        const std::lock_guard lock(preparing_);
        const auto found = std::ranges::find(prepared_, &model, &Prepared::model);
        if (found == prepared_.end())
            make();
        else
            model.obb_tree = std::move(found->obb_tree), prepared_.erase(found);
    }
    with_obb_trees_.push_back(&model);
    if (model.obb_tree->chunked()) with_chunks_.push_back(&model);
    reserved_.nodes += room.nodes, reserved_.bytes += room.bytes;
}

void ModelStore::look_ahead(std::vector<PrefetchPart> parts)
{
    if (!ahead_) ahead_ = std::make_unique<Prefetcher>([this](const PrefetchPart& part) { prepare(part); });
    ahead_->set(std::move(parts));
}

/// Runs in the prefetcher's thread. Ignores faults: they are reported when a pair needs the chunk.
void ModelStore::prepare(const PrefetchPart& part)
{
    constexpr std::uint32_t fine = 64; // triangles: smaller nodes grow fast enough during a traversal
    try {
        ObbTree* tree = nullptr;
        {
            const std::lock_guard lock(preparing_);
            const auto found = std::ranges::find(prepared_, part.model, &Prepared::model);
            if (found != prepared_.end())
                tree = found->obb_tree.get(), found->frame = frame_;
            else
                tree = part.model->obb_tree.get();
        }
        if (!tree) {
            const auto& cooked = std::get<std::shared_ptr<const CookedMesh>>(part.model->geometry().data);
            auto made = std::make_unique<ObbTree>(cooked, chunks_);
            const std::lock_guard lock(preparing_);
            tree = part.model->obb_tree.get();
            if (!tree) tree = made.get(), prepared_.push_back({part.model, std::move(made), frame_});
        }
        tree->grow_in(part.box, fine);
    } catch (const ChunkFault&) {
    } catch (const std::bad_alloc&) {
    }
}

/// Drops the prepared trees of one model, or all not requested for `age` frames. The prefetcher must be paused.
void ModelStore::drop_prepared(const Model* of, std::uint32_t frame, std::uint32_t age)
{
    const std::lock_guard lock(preparing_);
    std::erase_if(prepared_, [&](const Prepared& p) { return of ? p.model == of : frame - p.frame >= age; });
}

/// Drops the least recently needed chunks until at most `down_to` bytes are held.
void ModelStore::drop_chunks(std::size_t down_to) const
{
    struct Candidate : HeldChunks::Held {
        HeldChunks* of;
    };
    std::vector<Candidate> candidates;
    std::vector<HeldChunks::Held> held;
    const auto add = [&](HeldChunks* of) {
        held.clear();
        if (of) of->add_held(held);
        for (const HeldChunks::Held& chunk : held) candidates.push_back({chunk, of});
    };
    for (const Model* model : with_chunks_) add(model->obb_tree.get());
    for (const Model* model : grids_) add(model->held_grid());
    const std::lock_guard lock(preparing_);
    for (const Prepared& prepared : prepared_) add(prepared.obb_tree.get());
    std::ranges::stable_sort(candidates, {}, [](const Candidate& c) { return c.needed; });
    for (const Candidate& candidate : candidates) {
        if (chunks_.held() <= down_to) return;
        candidate.of->drop(candidate.chunk);
    }
}

void ModelStore::note(const std::string& fault) const
{
    const std::lock_guard lock(noting_);
    ++noted_[fault];
}

std::vector<std::string> ModelStore::faults() const
{
    const std::lock_guard lock(noting_);
    std::vector<std::string> lines;
    for (const auto& [what, pairs] : noted_)
        lines.push_back(fmt::format("{} ({} result{} undecided)", what, pairs, pairs == 1 ? "" : "s"));
    for (const Slot& slot : slots_)
        if (slot.model && slot.model->file())
            for (const std::string& what : slot.model->file()->faults())
                if (!noted_.contains(what)) lines.push_back(what);
    return lines;
}

void ModelStore::attach(std::uint32_t slot)
{
    const Model& model = by_number(slot);
    if (!backend_->attached(slot)) backend_->attach(slot, model.surface(model.spheres->root()));
}

/// Continues on the CPU after the GPU was lost. The trees keep their cells, and with them the error bounds of the
/// backend that found the cells, so results stay the same; only the triangle lists, which the GPU held, are rebuilt
/// level by level.
void ModelStore::take_over(const GpuLost& why)
{
    lost_ = why.what();
    backend_ = make_cpu_backend();
    for (std::uint32_t slot : with_spheres_) {
        Ocst& tree = *by_number(slot).spheres;
        tree.admit_backend(*backend_);
        if (!tree.nodes()[0].expanded()) continue;
        attach(slot);
        tree.rebuild_lists(slot, *backend_, threads_);
    }
}

/// Calls `work`, which uses the backend; calls it again if the GPU is lost meanwhile.
template <class Work>
void ModelStore::survive(Work work)
{
    try {
        work();
    } catch (const GpuLost& lost) {
        take_over(lost);
        work();
    }
}

void ModelStore::make_rows(std::span<const CellRequest> requests)
{
    rows_.clear();
    for (const CellRequest& request : requests) {
        attach(request.tree);
        rows_.push_back(by_number(request.tree).spheres->row(request.tree, request.cell));
    }
}

std::uint64_t ModelStore::submit(std::span<const CellRequest> requests, int threads)
{
    std::uint64_t allowed = requests.size();
    if (settings_.node_budget) {
        const std::uint64_t held = cells() + reserved_.nodes;
        // An expansion stores at most eight cells.
        allowed =
            settings_.node_budget > held ? std::min<std::uint64_t>(allowed, (settings_.node_budget - held) / 8) : 0;
    }
    if (settings_.memory_budget && sphere_bytes() + reserved_.bytes >= settings_.memory_budget) allowed = 0;

    threads_ = threads;
    survive([&] {
        make_rows(requests.first(allowed));
        backend_->submit(rows_, threads);
    });
    return requests.size() - allowed;
}

BatchWork ModelStore::grow(std::uint32_t frame)
{
    results_.resize(rows_.size());
    const auto tree_of = [&](const OctantRow& row) -> Ocst& { return *by_number(row.tree).spheres; };
    BatchWork work;
    try {
        work = backend_->collect(results_);
    } catch (const GpuLost& lost) {
        take_over(lost);
        for (OctantRow& row : rows_) attach(row.tree), row = tree_of(row).row(row.tree, row.cell);
        work = backend_->run(rows_, threads_, results_);
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) tree_of(rows_[i]).expand(rows_[i].cell, results_[i], frame);
    return work;
}

/// Drops a model's OBB tree and releases its reserved room. Returns the number of nodes dropped.
std::uint64_t ModelStore::drop_obb_tree(Model& model)
{
    if (!model.obb_tree) return 0;
    const Room less = all_grown(model);
    reserved_.nodes -= less.nodes, reserved_.bytes -= less.bytes;
    const std::uint64_t dropped = model.obb_tree->nodes();
    if (model.obb_tree->chunked()) std::erase(with_chunks_, &model);
    model.obb_tree.reset();
    return dropped;
}

void ModelStore::drop_spheres(std::uint32_t slot)
{
    if (!by_number(slot).spheres) return;
    if (backend_->attached(slot)) backend_->detach(slot);
    by_number(slot).spheres.reset();
    std::erase(with_spheres_, slot);
}

std::uint64_t ModelStore::collapse(std::uint32_t frame, std::uint32_t age)
{
    std::uint64_t dropped = 0;
    const Prefetcher::Pause pause(ahead_.get(), false);
    late_ = pause.failed();
    if (late_) return 0; // retried in the next frame
    drop_prepared(nullptr, frame, age);
    std::erase_if(with_obb_trees_, [&](Model* model) {
        if (frame - model->obb_tree_used < age) return false;
        dropped += drop_obb_tree(*model);
        return true;
    });
    for (std::uint32_t slot : with_spheres_) {
        Ocst& tree = *by_number(slot).spheres;
        if (!tree.nodes()[0].expanded()) continue;
        dropped += tree.collapse(frame, age, slot, *backend_);
        if (!tree.nodes()[0].expanded()) backend_->detach(slot);
    }
    return dropped;
}

std::uint64_t ModelStore::age(std::uint32_t frame)
{
    auto limit = static_cast<std::uint32_t>(settings_.age_limit);
    if (ahead_) {
        const std::lock_guard lock(preparing_);
        frame_ = frame;
    }
    std::uint64_t dropped = 0;
    // Checking every cell is expensive; a few checks per age limit are enough.
    if (late_ || frame % std::max(1u, limit / 8) == 0) dropped = collapse(frame, limit);
    while (settings_.memory_budget && limit > 0 && bytes() > settings_.memory_budget) {
        limit /= 2;
        dropped += collapse(frame, limit);
    }
    return dropped;
}

std::uint64_t ModelStore::cells() const
{
    std::uint64_t sum = 0;
    for (std::uint32_t slot : with_spheres_) sum += by_number(slot).spheres->size();
    return sum;
}

std::uint64_t ModelStore::nodes() const
{
    std::uint64_t sum = cells() + boxes_.nodes;
    for (const Model* model : with_chunks_) sum += model->obb_tree->nodes();
    return sum;
}

std::size_t ModelStore::sphere_bytes() const
{
    std::size_t sum = backend_->bytes();
    for (std::uint32_t slot : with_spheres_) sum += by_number(slot).spheres->bytes();
    return sum;
}

std::size_t ModelStore::bytes() const
{
    std::size_t sum = sphere_bytes() + boxes_.bytes;
    for (const Model* model : grids_) sum += model->grid_bytes();
    for (const Model* model : with_chunks_) sum += model->obb_tree->bytes();
    return sum;
}

} // namespace oncollide
