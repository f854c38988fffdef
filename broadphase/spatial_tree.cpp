#include <oncollide/broadphase/spatial_tree.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/broadphase/pair_sort.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

// One float step outward is at most 2^-23 of the magnitude, and a double rounds to float within half of that.
float below(double x)
{
    const float f = static_cast<float>(x);
    return f - std::abs(f) * 0x1p-23f - std::numeric_limits<float>::min();
}
float above(double x)
{
    return -below(-x);
}

} // namespace

void round_outward(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                   double margin, std::vector<FloatBox>& out)
{
    Aabb all;
    for (std::uint32_t body : bodies) all.add(boxes[body]);
    Eigen::Vector3d origin = all.centre();
    if (!origin.allFinite()) origin.setZero();
    const Eigen::Vector3d grow = Eigen::Vector3d::Constant(0.5 * margin);
    out.resize(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const Aabb& box = boxes[bodies[i]];
        const Eigen::Vector3d lo = box.min - grow - origin, hi = box.max + grow - origin;
        for (int axis = 0; axis < 3; ++axis) out[i].lo[axis] = below(lo[axis]), out[i].hi[axis] = above(hi[axis]);
        out[i].body = bodies[i];
        out[i].is_static = filter.is_static[bodies[i]];
    }
}

void BoxColumns::assign(std::span<const FloatBox> boxes)
{
    for (int c = 0; c < 6; ++c) {
        columns[c].resize(boxes.size() + 8);
        const int axis = c % 3;
        for (std::size_t i = 0; i < boxes.size(); ++i) columns[c][i] = c < 3 ? boxes[i].lo[axis] : boxes[i].hi[axis];
    }
}

BoxColumnsView BoxColumns::view() const
{
    return {{columns[0].data(), columns[1].data(), columns[2].data()},
            {columns[3].data(), columns[4].data(), columns[5].data()}};
}

namespace {

class SpatialTree final : public BroadPhase {
public:
    SpatialTree(std::string_view name, std::unique_ptr<NodeSplitter> splitter)
        : name_(name), splitter_(std::move(splitter))
    {
    }
    std::string_view name() const override { return name_; }

    void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                    double margin, int threads, std::vector<BodyPair>& pairs) override
    {
        pairs.clear();
        round_outward(boxes, bodies, filter, margin, boxes_);
        nodes_.clear();
        if (boxes_.size() < 2) return;
        build(0, static_cast<std::uint32_t>(boxes_.size()), add_node(), 0);
        columns_.assign(boxes_);

        filter_ = &filter;
        workers_.resize(static_cast<std::size_t>(std::max(threads, 1)));
        for (Worker& worker : workers_) worker.pairs.clear(), worker.active.clear();
        // Subtrees small enough to balance the threads are left for later as tasks; what lies above them is searched
        // now.
        task_size_ =
            threads > 1 && boxes_.size() > 4096 ? static_cast<std::uint32_t>(boxes_.size() / (8 * threads)) : 0;
        tasks_.clear(), task_active_.clear();
        search(workers_[0], 0, 0, task_size_ > 0);
        parallel_chunks(tasks_.size(), 1, threads, [&](std::size_t begin, std::size_t end, int thread) {
            Worker& worker = workers_[static_cast<std::size_t>(thread)];
            for (std::size_t i = begin; i < end; ++i) {
                const Task& task = tasks_[i];
                worker.active.assign(task_active_.begin() + task.first, task_active_.begin() + task.last);
                search(worker, task.node, 0, false);
            }
        });
        for (const Worker& worker : workers_) pairs.insert(pairs.end(), worker.pairs.begin(), worker.pairs.end());
        sort_pairs(pairs, scratch_, filter.is_static.size());
    }

private:
    struct Worker {
        std::vector<std::uint32_t> active; ///< stack of straddlers of the ancestors that reach the node at hand
        std::vector<std::uint32_t> found;
        std::vector<BodyPair> pairs;
    };
    struct Task {
        std::uint32_t node;
        std::ptrdiff_t first, last; ///< its active straddlers, in task_active_
    };

    std::uint32_t add_node()
    {
        nodes_.emplace_back();
        return static_cast<std::uint32_t>(nodes_.size() - 1);
    }

    void build(std::uint32_t begin, std::uint32_t end, std::uint32_t node, int depth)
    {
        constexpr std::uint32_t leaf_size = 24;
        constexpr int deepest = 48;
        std::array<std::uint32_t, 9> starts{};
        std::uint32_t children = 0, straddle_end = end;
        if (end - begin > leaf_size && depth < deepest) {
            const auto begins = splitter_->split(std::span(boxes_).subspan(begin, end - begin));
            for (std::uint32_t b : begins) starts[children++] = begin + b;
            starts[children] = end;
            if (children) straddle_end = starts[0];
        }
        SpatialNode made{begin, straddle_end, end, static_cast<std::uint32_t>(nodes_.size()), children, {}, {}, false};
        for (std::uint32_t c = 0; c < children; ++c) add_node();
        for (int axis = 0; axis < 3; ++axis) {
            made.lo[axis] = std::numeric_limits<float>::infinity();
            made.hi[axis] = -made.lo[axis];
        }
        const auto widen = [&made](const auto& box, bool moving) {
            for (int axis = 0; axis < 3; ++axis) {
                made.lo[axis] = std::min(made.lo[axis], box.lo[axis]);
                made.hi[axis] = std::max(made.hi[axis], box.hi[axis]);
            }
            made.has_moving |= moving;
        };
        for (std::uint32_t c = 0; c < children; ++c) {
            build(starts[c], starts[c + 1], made.first_child + c, depth + 1);
            widen(nodes_[made.first_child + c], nodes_[made.first_child + c].has_moving);
        }
        for (std::uint32_t i = begin; i < straddle_end; ++i) widen(boxes_[i], !boxes_[i].is_static);
        nodes_[node] = made;
    }

    void test(Worker& worker, std::uint32_t item, std::uint32_t begin, std::uint32_t end)
    {
        const FloatBox& box = boxes_[item];
        const float bounds[6] = {box.lo[0], box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2]};
        worker.found.resize(std::max<std::size_t>(worker.found.size(), end - begin + 8));
        const std::uint32_t count =
            box_kernel().overlap_range(columns_.view(), begin, end, bounds, worker.found.data());
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t a = box.body, b = boxes_[worker.found[k]].body;
            if (filter_->allows(a, b)) worker.pairs.push_back({std::min(a, b), std::max(a, b)});
        }
    }

    static bool reaches(const FloatBox& box, const SpatialNode& node)
    {
        return box.lo[0] <= node.hi[0] && box.hi[0] >= node.lo[0] && box.lo[1] <= node.hi[1] &&
               box.hi[1] >= node.lo[1] && box.lo[2] <= node.hi[2] && box.hi[2] >= node.lo[2] &&
               (node.has_moving || !box.is_static);
    }

    /// Pairs with at least one box in `node`, the other in it or among worker.active[first, ...).
    void search(Worker& worker, std::uint32_t index, std::size_t first, bool cut)
    {
        const SpatialNode& node = nodes_[index];
        const std::size_t last = worker.active.size();
        if (cut && node.end - node.begin <= task_size_) {
            tasks_.push_back({index, static_cast<std::ptrdiff_t>(task_active_.size()),
                              static_cast<std::ptrdiff_t>(task_active_.size() + last - first)});
            task_active_.insert(task_active_.end(), worker.active.begin() + static_cast<std::ptrdiff_t>(first),
                                worker.active.end());
            return;
        }
        for (std::uint32_t i = node.begin; i < node.straddle_end; ++i) test(worker, i, i + 1, node.straddle_end);
        if (node.begin < node.straddle_end)
            for (std::size_t i = first; i < last; ++i) test(worker, worker.active[i], node.begin, node.straddle_end);
        for (std::uint32_t c = node.first_child; c < node.first_child + node.children; ++c) {
            for (std::size_t i = first; i < last; ++i)
                if (reaches(boxes_[worker.active[i]], nodes_[c])) worker.active.push_back(worker.active[i]);
            for (std::uint32_t i = node.begin; i < node.straddle_end; ++i)
                if (reaches(boxes_[i], nodes_[c])) worker.active.push_back(i);
            if (nodes_[c].has_moving || worker.active.size() > last) search(worker, c, last, cut);
            worker.active.resize(last);
        }
    }

    std::string_view name_;
    std::unique_ptr<NodeSplitter> splitter_;
    std::vector<FloatBox> boxes_;
    std::vector<SpatialNode> nodes_;
    BoxColumns columns_;
    const BodyFilter* filter_ = nullptr;
    std::uint32_t task_size_ = 0;
    std::vector<Worker> workers_;
    std::vector<Task> tasks_;
    std::vector<std::uint32_t> task_active_;
    std::vector<BodyPair> scratch_;
};

} // namespace

std::unique_ptr<BroadPhase> make_octree()
{
    return std::make_unique<SpatialTree>("octree", make_octree_splitter());
}

} // namespace oncollide
