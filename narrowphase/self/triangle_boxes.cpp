#include <oncollide/narrowphase/self/triangle_boxes.hpp>

#include <algorithm>
#include <limits>
#include <utility>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/base/numbers/outward.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>

namespace oncollide {

namespace {

constexpr std::size_t grain = 4096;
constexpr int level_of_parts = 3; ///< 4,096 triangles

struct TriangleBox {
    double lo[3], hi[3];

    TriangleBox(const Mesh& mesh, std::uint32_t triangle)
    {
        const auto& [i, j, k] = mesh.triangles[triangle];
        const Eigen::Vector3d &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
        for (int axis = 0; axis < 3; ++axis) { // no branch, which would be unpredictable
            lo[axis] = std::min(std::min(a[axis], b[axis]), c[axis]);
            hi[axis] = std::max(std::max(a[axis], b[axis]), c[axis]);
        }
    }
    double edge() const { return std::max(std::max(hi[0] - lo[0], hi[1] - lo[1]), hi[2] - lo[2]); }
};

using Keys = std::unique_ptr<std::uint64_t[]>;

/// Spreads 10 bits to every third bit.
std::uint32_t spread(std::uint32_t x)
{
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

/// Keys along a curve through the octants of the mesh, in the upper 32 bits, over the numbers of the triangles. Large
/// boxes come after all others, by size, as one of them would make a node large.
Keys keys_of(const Mesh& mesh, int threads)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    std::vector<double> sample;
    for (std::uint32_t t = 0; t < count; t += std::max(1u, count / 1024)) sample.push_back(TriangleBox(mesh, t).edge());
    const auto middle = sample.begin() + std::ssize(sample) / 2;
    std::nth_element(sample.begin(), middle, sample.end());
    constexpr double least = std::numeric_limits<double>::min();
    const double per_median = 1 / std::max(*middle, least);
    const Eigen::Vector3d low = mesh.bounds.min; // for the order alone, so it need not be right
    const double per_cell = 511.5 / std::max((mesh.bounds.max - low).maxCoeff(), least);
    Keys keys = std::make_unique_for_overwrite<std::uint64_t[]>(count);
    parallel_chunks(count, grain, threads, [&](std::size_t begin, std::size_t end, int) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            const TriangleBox box(mesh, t);
            std::uint32_t key = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const double cell = ((box.lo[axis] - low[axis]) + (box.hi[axis] - low[axis])) * per_cell;
                key |= spread(static_cast<std::uint32_t>(std::max(std::min(cell, 1023.0), 0.0))) << axis;
            }
            const double ratio = box.edge() * per_median;
            const std::uint32_t size_class = std::uint32_t(ratio > 4) + (ratio > 16) + (ratio > 64);
            keys[t] = std::uint64_t{size_class << 30 | key} << 32 | t;
        }
    });
    return keys;
}

/// Sorts by the upper 32 bits. Equal ones stay in their order.
void radix_sort(Keys& keys, std::size_t count)
{
    constexpr int digits = 3, bits = 11;
    constexpr std::uint32_t values = 1u << bits;
    std::vector<std::uint32_t> next(std::size_t{digits} * values);
    const auto digit = [](std::uint64_t key, int d) { return key >> (32 + bits * d) & (values - 1); };
    for (std::size_t i = 0; i < count; ++i)
        for (int d = 0; d < digits; ++d) ++next[std::size_t(d) * values + digit(keys[i], d)];
    Keys other = std::make_unique_for_overwrite<std::uint64_t[]>(count);
    for (int d = 0; d < digits; ++d) {
        std::uint32_t* const of = next.data() + std::size_t(d) * values;
        for (std::uint32_t v = 0, sum = 0; v < values; ++v) sum += std::exchange(of[v], sum);
        for (std::size_t i = 0; i < count; ++i) other[of[digit(keys[i], d)]++] = keys[i];
        keys.swap(other);
    }
}

} // namespace

TriangleBoxes::TriangleBoxes(const Mesh& mesh, double within, int threads)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    Keys keys = keys_of(mesh, threads);
    radix_sort(keys, count);
    order_ = std::make_unique_for_overwrite<std::uint32_t[]>(count);
    for (std::uint32_t place = 0; place < count; ++place) order_[place] = static_cast<std::uint32_t>(keys[place]);
    add_levels(count);
    set_boxes(mesh, within, threads);
    divide();
}

void TriangleBoxes::set_boxes(const Mesh& mesh, double within, int threads)
{
    const Eigen::Vector3d origin = mesh.vertices[mesh.triangles[0][0]];
    const double half = 0.5 * within * (1 + 0x1p-30); // differences of doubles are rounded by far less
    parallel_chunks(mesh.triangles.size(), grain, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t place = begin; place < end; ++place) {
            const TriangleBox box(mesh, order_[place]);
            float* const to = blocks_[0].get() + place / 16 * aabb_block + place % 16;
            for (int axis = 0; axis < 3; ++axis) {
                to[16 * axis] = below(box.lo[axis] - origin[axis] - half);
                to[48 + 16 * axis] = above(box.hi[axis] - origin[axis] + half);
            }
        }
    });
    for (std::size_t level = 1; level < blocks_.size(); ++level)
        for (std::uint32_t node = 0; node < view_.level[level].count; ++node) {
            float box[6];
            aabb_tree_kernel().bound(view_.level[level - 1], node, box);
            for (std::size_t c = 0; c < 6; ++c)
                blocks_[level][std::size_t{node / 16} * aabb_block + 16 * c + node % 16] = box[c];
        }
}

void TriangleBoxes::divide()
{
    if (view_.levels <= level_of_parts) return parts_.push_back({});
    for (std::uint32_t node = 0; node < view_.level[level_of_parts].count; ++node) parts_.push_back({node, node});
    find_in_chunks(
        [&](const std::uint32_t* i, const std::uint32_t* j, std::uint64_t found) {
            for (std::uint64_t k = 0; k < found; ++k) parts_.push_back({i[k], j[k]});
        },
        [&](PairSink& sink) { aabb_tree_kernel().all(view_, level_of_parts, sink); });
    std::ranges::sort(parts_);
}

void TriangleBoxes::find(Part part, PairSink& sink) const
{
    const AabbTreeKernel& kernel = aabb_tree_kernel();
    if (view_.levels <= level_of_parts) return kernel.all(view_, 0, sink);
    if (part.first == part.second) return kernel.within(view_, level_of_parts, part.first, sink);
    kernel.between(view_, level_of_parts, part.first, part.second, sink);
}

/// Makes levels whose boxes are not set yet, except the empty ones that fill the last blocks.
void TriangleBoxes::add_levels(std::uint32_t count)
{
    for (bool top = false; !top; count = (count + 15) / 16) {
        top = count <= 16;
        const std::size_t floats = std::size_t{(count + 15) / 16} * aabb_block;
        float* const blocks = blocks_.emplace_back(std::make_unique_for_overwrite<float[]>(floats)).get();
        std::fill_n(blocks + floats - aabb_block, aabb_block / 2, float_infinity);
        std::fill_n(blocks + floats - aabb_block / 2, aabb_block / 2, -float_infinity);
        std::vector<std::uint16_t>& there = there_.emplace_back((count + 15) / 16, 0xffff);
        if (count % 16) there.back() = static_cast<std::uint16_t>((1u << count % 16) - 1);
        view_.level[view_.levels++] = {blocks, count, there.data(), nullptr, nullptr, nullptr};
    }
}

} // namespace oncollide
