#include <oncollide/pipeline/forest.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace oncollide {

Forest::Forest(const Scene& scene, const Settings& settings, std::unique_ptr<OcclusionBackend> backend)
    : scene_(scene), settings_(settings), backend_(std::move(backend)), obb_trees_(scene),
      trees_(scene.geometries.size())
{
    if (settings.mode == Mode::solid) solids_.emplace(scene, settings.open_as_surface);
}

/// The smallest depth at which two such trees certify the error asked for.
int Forest::depth_for(const RootCell& root, double covering_error) const
{
    if (!settings_.max_error) return settings_.depth.value_or(6);
    for (int depth = 1; depth < deepest_level; ++depth) {
        const Ocst tree(root, depth, covering_error);
        // Rounding of the walk (see make_plan) is below 2^-15 of the two root radii for bodies that touch.
        const double error = 4 * tree.radius(depth) + 2 * tree.reach(*backend_, depth) + 4 * root.radius * 0x1p-15;
        if (error <= *settings_.max_error) return depth;
    }
    return deepest_level;
}

Ocst& Forest::tree(GeometryId geometry)
{
    auto& tree = trees_[index(geometry)];
    if (!tree) {
        const Geometry& g = scene_.geometries[index(geometry)];
        const RootCell root = root_cell_of(g);
        const double covering_error = covering_error_of(g);
        tree = std::make_unique<Ocst>(root, depth_for(root, covering_error), covering_error);
        live_.push_back(index(geometry));
    }
    return *tree;
}

WalkPair Forest::walk_pair(const Scene& scene, std::uint32_t a, std::uint32_t b, LeafPair hint)
{
    const GeometryId ga = scene.geometry[a], gb = scene.geometry[b];
    return {&tree(ga), &tree(gb), index(ga), index(gb), &scene.poses[a], &scene.poses[b], settings_.clearance, hint};
}

bool Forest::admit_triangles(GeometryId geometry, std::uint32_t frame)
{
    const auto left = [](auto budget, auto held) -> decltype(budget) {
        if (budget == 0) return std::numeric_limits<decltype(budget)>::max();
        return budget > held ? budget - held : 0;
    };
    const ObbTrees::Room& reserved = obb_trees_.reserved();
    return obb_trees_.admit(geometry, frame,
                            {left(std::uint64_t(settings_.node_budget), cells() + reserved.nodes),
                             left(settings_.memory_budget, sphere_bytes() + reserved.bytes)});
}

double Forest::tolerance(GeometryId a, GeometryId b)
{
    if (settings_.max_error) return *settings_.max_error;
    const double diagonals = obb_trees_[a].mesh().bounds.diagonal() + obb_trees_[b].mesh().bounds.diagonal();
    return std::ldexp(diagonals, -settings_.depth.value_or(6));
}

void Forest::attach(std::uint32_t geometry)
{
    if (!backend_->attached(geometry))
        backend_->attach(geometry, make_surface(scene_.geometries[geometry], trees_[geometry]->root()));
}

/// The CPU goes on where the GPU stopped. The trees keep their cells, so the answers stay the same; only the triangle
/// lists, which the GPU held, are asked for again, level by level.
void Forest::take_over(const GpuLost& why)
{
    lost_ = why.what();
    backend_ = make_cpu_backend();
    for (std::uint32_t geometry : live_) {
        Ocst& tree = *trees_[geometry];
        if (!tree.nodes()[0].expanded()) continue;
        attach(geometry);
        tree.ask_lists_again(geometry, *backend_, threads_);
    }
}

/// Does `work`, which uses the backend; once more if the GPU is lost over it.
template <class Work>
void Forest::survive(Work work)
{
    try {
        work();
    } catch (const GpuLost& lost) {
        take_over(lost);
        work();
    }
}

void Forest::make_rows(std::span<const CellRequest> requests)
{
    rows_.clear();
    for (const CellRequest& request : requests) {
        attach(request.tree);
        rows_.push_back(trees_[request.tree]->row(request.tree, request.cell));
    }
}

std::uint64_t Forest::submit(std::span<const CellRequest> requests, int threads)
{
    std::uint64_t allowed = requests.size();
    if (settings_.node_budget) {
        const std::uint64_t held = cells() + obb_trees_.reserved().nodes;
        // An expansion stores up to eight cells.
        allowed =
            settings_.node_budget > held ? std::min<std::uint64_t>(allowed, (settings_.node_budget - held) / 8) : 0;
    }
    if (settings_.memory_budget && sphere_bytes() + obb_trees_.reserved().bytes >= settings_.memory_budget) allowed = 0;

    threads_ = threads;
    survive([&] {
        make_rows(requests.first(allowed));
        backend_->submit(rows_, threads);
    });
    return requests.size() - allowed;
}

BatchWork Forest::grow(std::uint32_t frame)
{
    answers_.resize(rows_.size());
    BatchWork work;
    try {
        work = backend_->collect(answers_);
    } catch (const GpuLost& lost) {
        take_over(lost);
        for (OctantRow& row : rows_) attach(row.tree), row = trees_[row.tree]->row(row.tree, row.cell);
        work = backend_->ask(rows_, threads_, answers_);
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) trees_[rows_[i].tree]->expand(rows_[i].cell, answers_[i], frame);
    return work;
}

void Forest::triangles(std::span<const CellTriangles> cells, std::vector<std::uint32_t>& out,
                       std::vector<std::size_t>& ends)
{
    const std::size_t first = out.size();
    std::vector<std::size_t>& read_ends = read_ends_;
    survive([&] {
        out.resize(first), read_ends.clear(), reads_.clear();
        for (const CellTriangles& c : cells)
            if (const ListId list = list_of(c); list != all_triangles)
                reads_.push_back({index(c.geometry), list, octant_of(c.cell)});
        backend_->read(reads_, out, read_ends);
    });
    std::size_t end = first, read = 0;
    for (const CellTriangles& c : cells) {
        if (list_of(c) != all_triangles) end = read_ends[read++];
        ends.push_back(end);
    }
}

ListId Forest::list_of(const CellTriangles& cell) const
{
    const auto& tree = trees_[index(cell.geometry)];
    return tree && cell.cell && tree->knows(cell.cell) ? tree->parent_list(cell.cell) : all_triangles;
}

CellKey Forest::cell_at(GeometryId geometry, const Eigen::Vector3d& point, int up) const
{
    const auto& tree = trees_[index(geometry)];
    return tree ? tree->cell_at(point, std::max(tree->depth() - up, 1)) : CellKey{0};
}

std::uint64_t Forest::collapse(std::uint32_t frame, std::uint32_t age)
{
    std::uint64_t dropped = obb_trees_.drop(frame, age);
    for (std::uint32_t geometry : live_) {
        Ocst& tree = *trees_[geometry];
        if (!tree.nodes()[0].expanded()) continue;
        dropped += tree.collapse(frame, age, geometry, *backend_);
        if (!tree.nodes()[0].expanded()) backend_->detach(geometry);
    }
    return dropped;
}

std::uint64_t Forest::age(std::uint32_t frame)
{
    auto limit = static_cast<std::uint32_t>(settings_.age_limit);
    std::uint64_t dropped = 0;
    // Looking at every cell costs; a few looks an age are enough.
    if (frame % std::max(1u, limit / 8) == 0) dropped = collapse(frame, limit);
    while (settings_.memory_budget && limit > 0 && bytes() > settings_.memory_budget) {
        limit /= 2;
        dropped += collapse(frame, limit);
    }
    return dropped;
}

std::uint64_t Forest::cells() const
{
    std::uint64_t sum = 0;
    for (std::uint32_t geometry : live_) sum += trees_[geometry]->size();
    return sum;
}

std::uint64_t Forest::nodes() const
{
    return cells() + obb_trees_.nodes();
}

std::size_t Forest::sphere_bytes() const
{
    std::size_t sum = backend_->bytes();
    for (std::uint32_t geometry : live_) sum += trees_[geometry]->bytes();
    return sum;
}

std::size_t Forest::bytes() const
{
    return sphere_bytes() + obb_trees_.bytes();
}

} // namespace oncollide
