#include <oncollide/narrowphase/self/self_pairs.hpp>

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/exact/neighbours.hpp>
#include <oncollide/narrowphase/self/spread_fans.hpp>
#include <oncollide/narrowphase/self/triangle_boxes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;
using FourKeys = std::uint32_t __attribute__((vector_size(16)));

/// A triangle, with a key for each corner. The corners of two triangles have equal keys if they are one vertex, whose
/// fan is spread.
struct KeyedTriangle {
    std::uint32_t key[4]; ///< the last one is no other triangle's
};
constexpr std::uint32_t no_vertex = 1u << 31; ///< keys from here on belong to one corner alone

bool have_equal_keys(const KeyedTriangle& a, const KeyedTriangle& b)
{
    FourKeys of_b;
    __builtin_memcpy(&of_b, &b, sizeof of_b);
    const auto equal = (of_b == a.key[0]) | (of_b == a.key[1]) | (of_b == a.key[2]);
    std::uint64_t halves[2];
    __builtin_memcpy(halves, &equal, sizeof halves);
    return (halves[0] | halves[1]) != 0;
}

/// True if the triangle shares no vertex with any triangle whose keys all differ from its own.
bool all_spread(const KeyedTriangle& t)
{
    return (t.key[0] | t.key[1] | t.key[2]) < no_vertex;
}

/// The data that all parts of the search read.
struct SelfSearch {
    const Mesh& mesh;
    const std::vector<std::uint8_t> spread; ///< by vertex; comes first, as boxes then take its scratch memory
    const TriangleBoxes boxes;
    std::unique_ptr<KeyedTriangle[]> triangles; ///< by place in the boxes

    SelfSearch(const Mesh& of, int threads)
        : mesh(of), spread(spread_fans(of, threads)), boxes(of, 0, threads),
          triangles(std::make_unique_for_overwrite<KeyedTriangle[]>(of.triangles.size()))
    {
        key_triangles(threads);
    }

    void key_triangles(int threads)
    {
        parallel_chunks(mesh.triangles.size(), 4096, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t place = begin; place < end; ++place) {
                const Triangle& triangle = mesh.triangles[boxes.triangle_at(static_cast<std::uint32_t>(place))];
                // Keys of one place are not compared, so they may be equal.
                const std::uint32_t own = no_vertex | static_cast<std::uint32_t>(place);
                for (std::uint32_t k = 0; k < 3; ++k) {
                    const std::uint32_t v = triangle[k];
                    triangles[place].key[k] = spread[v] && v < no_vertex ? v : own;
                }
                triangles[place].key[3] = own;
            }
        });
    }
};

/// The work of one thread.
class PartSearch {
public:
    explicit PartSearch(const SelfSearch& in) : in_(in) {}

    /// Appends the pairs of a part to `found`, in any order.
    void run(std::size_t part, std::vector<TrianglePair>& found)
    {
        found_ = &found;
        in_.boxes.find(part, [&](const std::uint32_t* i, const std::uint32_t* j, std::uint64_t count) {
            left_.resize(count);
            std::size_t left = 0; // no branch on the keys, which is unpredictable
            for (std::uint32_t k = 0; k < count; ++k) {
                left_[left] = k;
                left += !have_equal_keys(in_.triangles[i[k]], in_.triangles[j[k]]);
            }
            for (const std::uint32_t k : std::span(left_).first(left)) test(i[k], j[k]);
        });
        test_apart();
    }

private:
    const Vector3d& at(std::uint32_t vertex) const { return in_.mesh.vertices[vertex]; }

    /// @param i, j  places in the boxes
    void test(std::uint32_t i, std::uint32_t j)
    {
        const auto [s, t] = std::minmax({in_.boxes.triangle_at(i), in_.boxes.triangle_at(j)});
        const TrianglePair pair{s, t};
        if (all_spread(in_.triangles[i]) || all_spread(in_.triangles[j])) return test_later(pair);
        decide_neighbours(pair);
    }
    /// Decides neighbours by the vertices that they share, where that is certain. Vertices at one position with
    /// different indices are left to the exact test.
    void decide_neighbours(TrianglePair pair)
    {
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
        for (std::size_t i = 0; i < search.boxes.parts() && all.size() < most; ++i) {
            const auto begin = static_cast<std::ptrdiff_t>(all.size());
            worker.run(i, all);
            std::sort(all.begin() + begin, all.end());
        }
        all.resize(std::min(all.size(), most));
    } else {
        std::vector<std::vector<TrianglePair>> found(search.boxes.parts());
        parallel_chunks(search.boxes.parts(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
            PartSearch worker(search);
            for (std::size_t i = begin; i < end; ++i) worker.run(i, found[i]);
        });
        for (const std::vector<TrianglePair>& pairs : found) all.insert(all.end(), pairs.begin(), pairs.end());
    }
    std::ranges::sort(all, {}, [](const TrianglePair& pair) { return std::uint64_t{pair.a} << 32 | pair.b; });
    return all;
}

} // namespace oncollide
