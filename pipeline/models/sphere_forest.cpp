#include <oncollide/pipeline/models/sphere_forest.hpp>

#include <algorithm>

namespace oncollide {

Ocst& SphereForest::tree(Model& model, double max_error)
{
    ahead_.clear();
    if (!model.spheres_) {
        model.spheres_ = std::make_unique<Ocst>(model.root_cell(), 1, model.covering_error());
        model.spheres_->admit_backend(*backend_);
        trees_.push_back(model.number());
    }
    model.spheres_->deepen(depth(model, max_error));
    return *model.spheres_;
}

int SphereForest::depth(const Model& model, double max_error) const
{
    if (settings_.depth) return *settings_.depth;
    const Ocst& tree = *model.spheres();
    // Rounding in the traversal (see make_plan) is below 2^-15 of the two root radii for bodies that touch.
    const double rounding = 4 * tree.radius(0) * 0x1p-15;
    int depth = 1;
    while (depth < deepest_level && 4 * tree.radius(depth) + 2 * tree.error(depth) + rounding > max_error) ++depth;
    return depth;
}

void SphereForest::attach(std::uint32_t number)
{
    if (!backend_->attached(number))
        backend_->attach(number, models_.by_number(number).surface(tree_of(number).root()));
}

/// Continues on the CPU after the GPU was lost. The trees keep their cells, and with them the error bounds of the
/// backend that found the cells, so results stay the same; only the triangle lists, which the GPU held, are rebuilt
/// level by level.
void SphereForest::take_over(const GpuLost& why)
{
    lost_ = why.what();
    backend_ = make_cpu_backend();
    for (std::uint32_t number : trees_) {
        Ocst& tree = tree_of(number);
        tree.admit_backend(*backend_);
        if (!tree.nodes()[0].expanded()) continue;
        attach(number);
        tree.rebuild_lists(number, *backend_, threads_);
    }
}

/// Calls `work`, which uses the backend; calls it again if the GPU is lost meanwhile.
template <class Work>
void SphereForest::survive(Work work)
{
    try {
        work();
    } catch (const GpuLost& lost) {
        take_over(lost);
        work();
    }
}

void SphereForest::make_rows(std::span<const CellRequest> requests)
{
    rows_.clear();
    for (const CellRequest& request : requests) {
        attach(request.tree);
        rows_.push_back(tree_of(request.tree).row(request.tree, request.cell));
    }
}

void SphereForest::submit(std::span<const CellRequest> requests, int threads)
{
    threads_ = threads;
    if (!ahead_.empty()) { // these are grey children of expanded cells, so they are stored and not expanded
        requests_.assign(requests.begin(), requests.end());
        requests_.insert(requests_.end(), ahead_.begin(), ahead_.end());
        std::sort(requests_.begin(), requests_.end());
        requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
        requests = requests_;
    }
    survive([&] {
        make_rows(requests);
        backend_->submit(rows_, threads);
    });
}

BatchWork SphereForest::grow(std::uint32_t frame)
{
    results_.resize(rows_.size());
    BatchWork work;
    try {
        work = backend_->collect(results_);
    } catch (const GpuLost& lost) {
        take_over(lost);
        for (OctantRow& row : rows_) attach(row.tree), row = tree_of(row.tree).row(row.tree, row.cell);
        work = backend_->run(rows_, threads_, results_);
    }
    ahead_.clear();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const OctantRow& row = rows_[i];
        tree_of(row.tree).expand(row.cell, results_[i], frame);
        for (unsigned k = 0; k < 8 && grows_ahead_ && row.keep_list; ++k)
            if (results_[i].grey >> k & 1) ahead_.push_back({row.tree, child_cell(row.cell, k)});
    }
    return work;
}

std::uint64_t SphereForest::collapse(std::uint32_t frame, std::uint32_t age)
{
    std::uint64_t dropped = 0;
    ahead_.clear();
    for (std::uint32_t number : trees_) {
        Ocst& tree = tree_of(number);
        if (!tree.nodes()[0].expanded()) continue;
        dropped += tree.collapse(frame, age, number, *backend_);
        if (!tree.nodes()[0].expanded()) backend_->detach(number);
    }
    return dropped;
}

void SphereForest::drop(Model& model)
{
    if (!model.spheres_) return;
    ahead_.clear();
    if (backend_->attached(model.number())) backend_->detach(model.number());
    model.spheres_.reset();
    std::erase(trees_, model.number());
}

std::uint64_t SphereForest::cells() const
{
    std::uint64_t sum = 0;
    for (std::uint32_t number : trees_) sum += tree_of(number).size();
    return sum;
}

std::size_t SphereForest::bytes() const
{
    std::size_t sum = backend_->bytes();
    for (std::uint32_t number : trees_) sum += tree_of(number).bytes();
    return sum;
}

} // namespace oncollide
