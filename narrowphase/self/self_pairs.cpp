#include <oncollide/narrowphase/self/self_pairs.hpp>

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/tree/aabb_tree.hpp>
#include <oncollide/broadphase/tree/pair_lists.hpp>
#include <oncollide/narrowphase/exact/neighbours.hpp>
#include <oncollide/narrowphase/self/spread_fans.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;
using FourKeys = std::uint32_t __attribute__((vector_size(16)));

/// Two nodes of the AABB tree at one level, or one node twice. Parts of the search may run at the same time.
using Part = std::pair<std::uint32_t, std::uint32_t>;
constexpr int level_of_parts = 3; ///< 4,096 triangles

/// A triangle, with a key for each corner. The corners of two triangles have equal keys if they are one vertex, whose
/// fan is spread.
struct KeyedTriangle {
    std::uint32_t key[3], number;
};
constexpr std::uint32_t no_vertex = 1u << 31; ///< keys from here on belong to one corner alone

bool have_equal_keys(const KeyedTriangle& a, const KeyedTriangle& b)
{
    FourKeys of_b;
    __builtin_memcpy(&of_b, &b, sizeof of_b);
    const auto equal = (of_b == a.key[0]) | (of_b == a.key[1]) | (of_b == a.key[2]);
    return equal[0] | equal[1] | equal[2];
}

/// True if the triangle shares no vertex with any triangle whose keys all differ from its own.
bool all_spread(const KeyedTriangle& t)
{
    return (t.key[0] | t.key[1] | t.key[2]) < no_vertex;
}

/// The data that all parts of the search read.
struct SelfSearch {
    const Mesh& mesh;
    AabbTree tree{AabbOrder::octree};
    LargeVector<KeyedTriangle> triangles; ///< by place in the tree
    std::vector<Part> parts;              ///< sorted; one without nodes: the whole tree

    SelfSearch(const Mesh& of, int threads) : mesh(of)
    {
        const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
        LargeVector<Aabb> boxes(count);
        for (std::uint32_t t = 0; t < count; ++t)
            for (const std::uint32_t v : mesh.triangles[t]) boxes[t].add(mesh.vertices[v]);
        std::vector<std::uint32_t> all(count);
        std::iota(all.begin(), all.end(), 0u);
        tree.build(boxes, all, 0, threads);
        tree.set_moving(std::vector<std::uint8_t>(count, 1).data(), 1);
        key_triangles();
        if (tree.view().levels <= level_of_parts) {
            parts.push_back({});
            return;
        }
        for (std::uint32_t node = 0; node < tree.view().level[level_of_parts].count; ++node)
            parts.push_back({node, node});
        find_in_chunks(
            [&](const std::uint32_t* i, const std::uint32_t* j, std::uint64_t found) {
                for (std::uint64_t k = 0; k < found; ++k) parts.push_back({i[k], j[k]});
            },
            [&](PairSink& sink) { aabb_tree_kernel().all(tree.view(), level_of_parts, sink); });
        std::ranges::sort(parts);
    }

    void key_triangles()
    {
        const std::vector<std::uint8_t> spread = spread_fans(mesh);
        triangles.resize(tree.size());
        for (std::uint32_t place = 0; place < tree.size(); ++place) {
            KeyedTriangle& keyed = triangles[place];
            keyed.number = tree.body_at(place);
            if (keyed.number == no_body) continue;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t v = mesh.triangles[keyed.number][k];
                // Two corners of one place never meet, so they may have one key.
                keyed.key[k] = spread[v] && v < no_vertex ? v : no_vertex | place;
            }
        }
    }
};

/// The work of one thread.
class PartSearch {
public:
    explicit PartSearch(const SelfSearch& in) : in_(in) {}

    /// Appends the pairs of a part to `found`, in any order.
    void run(const Part& part, std::vector<TrianglePair>& found)
    {
        const AabbTreeKernel& kernel = aabb_tree_kernel();
        const AabbTreeView& view = in_.tree.view();
        found_ = &found;
        const auto take = [&](const std::uint32_t* i, const std::uint32_t* j, std::uint64_t count) {
            left_.resize(count);
            std::size_t left = 0; // no branch on the keys, which is unpredictable
            for (std::uint32_t k = 0; k < count; ++k) {
                left_[left] = k;
                left += !have_equal_keys(in_.triangles[i[k]], in_.triangles[j[k]]);
            }
            for (const std::uint32_t k : std::span(left_).first(left)) test(in_.triangles[i[k]], in_.triangles[j[k]]);
        };
        find_in_chunks(take, [&](PairSink& sink) {
            if (view.levels <= level_of_parts) return kernel.all(view, 0, sink);
            if (part.first == part.second) return kernel.within(view, level_of_parts, part.first, sink);
            kernel.between(view, level_of_parts, part.first, part.second, sink);
        });
        test_apart();
    }

private:
    const Vector3d& at(std::uint32_t vertex) const { return in_.mesh.vertices[vertex]; }

    /// Decides neighbours by the vertices that they share, where that is certain. Vertices at one position with
    /// different indices are left to the exact test.
    void test(const KeyedTriangle& s, const KeyedTriangle& t)
    {
        const TrianglePair pair{std::min(s.number, t.number), std::max(s.number, t.number)};
        if (all_spread(s) || all_spread(t)) return test_later(pair);
        const Triangle &a = in_.mesh.triangles[pair.a], &b = in_.mesh.triangles[pair.b];
        unsigned same = 0; // bit 3 i + j: corner i of a is corner j of b
        for (unsigned i = 0; i < 3; ++i)
            for (unsigned j = 0; j < 3; ++j) same |= unsigned(a[i] == b[j]) << (3 * i + j);
        if (!same) return test_later(pair);
        const auto first = static_cast<unsigned>(std::countr_zero(same)), i = first / 3, j = first % 3;
        same &= same - 1;
        if (!same) {
            if (certainly_share_corner_only(at(a[i]), at(a[(i + 1) % 3]), at(a[(i + 2) % 3]), at(b[(j + 1) % 3]),
                                            at(b[(j + 2) % 3])))
                return;
        } else if (!(same & (same - 1))) {
            const auto second = static_cast<unsigned>(std::countr_zero(same)), k = second / 3, l = second % 3;
            if (i != k && j != l && certainly_share_edge_only(at(a[i]), at(a[k]), at(a[3 - i - k]), at(b[3 - j - l])))
                return;
        }
        test_exactly(pair);
    }
    void test_later(TrianglePair pair)
    {
        apart_[apart_count_++] = pair;
        if (apart_count_ == 8) test_apart();
    }
    /// Tests the pairs without a common vertex that wait.
    void test_apart()
    {
        constexpr double no_rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, no_translation[3] = {0, 0, 0};
        const unsigned count = std::exchange(apart_count_, 0);
        if (!count) return;
        CornersOfPairs corners;
        for (unsigned i = 0; i < 8; ++i) { // unused lanes repeat the last pair
            const TrianglePair& pair = apart_[std::min(i, count - 1)];
            for (std::size_t k = 0; k < 3; ++k) {
                corners.a[k][i] = at(in_.mesh.triangles[pair.a][k]).data();
                corners.b[k][i] = at(in_.mesh.triangles[pair.b][k]).data();
            }
        }
        const unsigned separate = judge_pairs()(corners, no_rotation, no_translation, nullptr).separate;
        for (unsigned rest = ~separate & ((1u << count) - 1); rest; rest &= rest - 1)
            test_exactly(apart_[std::countr_zero(rest)]);
    }
    void test_exactly(TrianglePair pair)
    {
        const auto points = [&](std::uint32_t triangle) -> TrianglePoints {
            const auto& [a, b, c] = in_.mesh.triangles[triangle];
            return {at(a), at(b), at(c)};
        };
        if (meet_beyond_shared(points(pair.a), points(pair.b))) found_->push_back(pair);
    }

    const SelfSearch& in_;
    std::vector<TrianglePair>* found_ = nullptr;
    std::vector<std::uint32_t> left_; ///< numbers of pairs in a chunk that have no equal keys
    TrianglePair apart_[8];           ///< pairs without a common vertex, which are tested together
    unsigned apart_count_ = 0;
};

} // namespace

std::vector<TrianglePair> self_pairs(const Mesh& mesh, std::size_t most, int threads)
{
    std::vector<TrianglePair> all;
    if (most == 0) return all;
    const SelfSearch search(mesh, threads);
    if (most != std::numeric_limits<std::size_t>::max()) { // which parts run must not depend on their speed
        PartSearch worker(search);
        for (std::size_t i = 0; i < search.parts.size() && all.size() < most; ++i) {
            const auto begin = static_cast<std::ptrdiff_t>(all.size());
            worker.run(search.parts[i], all);
            std::sort(all.begin() + begin, all.end());
        }
        all.resize(std::min(all.size(), most));
    } else {
        std::vector<std::vector<TrianglePair>> found(search.parts.size());
        parallel_chunks(search.parts.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
            PartSearch worker(search);
            for (std::size_t i = begin; i < end; ++i) worker.run(search.parts[i], found[i]);
        });
        for (const std::vector<TrianglePair>& pairs : found) all.insert(all.end(), pairs.begin(), pairs.end());
    }
    std::ranges::sort(all, {}, [](const TrianglePair& pair) { return std::uint64_t{pair.a} << 32 | pair.b; });
    return all;
}

} // namespace oncollide
