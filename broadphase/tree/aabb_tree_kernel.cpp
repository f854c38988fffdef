// Compiled once per instruction set; see oncollide_add_kernel.
#include <cstddef>

#include <oncollide/base/simd/simd.hpp>
#include <oncollide/broadphase/tree/aabb_tree_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

constexpr std::uint32_t width = 16;

struct Query {
    float lo[3], hi[3];
};

inline Query query_of(const AabbLevelView& level, std::uint32_t i)
{
    const float* p = level.blocks + std::size_t{i / width} * aabb_block + i % width;
    return {{p[0], p[16], p[32]}, {p[48], p[64], p[80]}};
}

/// A block, which is compared with several queries. With AVX-512 it is in registers: the compiler would load it again
/// after each result that is stored.
struct Block {
    Block(const AabbLevelView& level, std::uint32_t block) : p(level.blocks + std::size_t{block} * aabb_block)
    {
#if defined(__AVX512F__)
        for (int c = 0; c < 6; ++c) columns[c] = _mm512_loadu_ps(p + 16 * c);
#endif
    }
    const float* p;
#if defined(__AVX512F__)
    __m512 columns[6];
#endif
};

/// Bit k is set if box k of the block overlaps the query.
inline unsigned hits(const Block& block, const Query& q)
{
#if defined(__AVX512F__)
    const auto low = [&](int axis, __mmask16 m) {
        return _mm512_mask_cmp_ps_mask(m, block.columns[axis], _mm512_set1_ps(q.hi[axis]), _CMP_LE_OQ);
    };
    const auto high = [&](int axis, __mmask16 m) {
        return _mm512_mask_cmp_ps_mask(m, block.columns[3 + axis], _mm512_set1_ps(q.lo[axis]), _CMP_GE_OQ);
    };
    // Two dependency chains, so that a comparison does not wait for all previous ones.
    return static_cast<__mmask16>(low(0, low(1, low(2, 0xffff))) & high(0, high(1, high(2, 0xffff))));
#elif defined(__AVX2__) || !defined(__SSE2__)
    const float* const p = block.p;
    const auto half = [&](const float* v) {
        return bits((load(v) <= splat(q.hi[0])) & (load(v + 48) >= splat(q.lo[0])) & (load(v + 16) <= splat(q.hi[1])) &
                    (load(v + 64) >= splat(q.lo[1])) & (load(v + 32) <= splat(q.hi[2])) &
                    (load(v + 80) >= splat(q.lo[2])));
    };
    return half(p) | half(p + 8) << 8;
#else
    const float* const p = block.p;
    const auto quarter = [&](const float* v) {
        const auto low = [&](int axis) { return _mm_cmple_ps(_mm_loadu_ps(v + 16 * axis), _mm_set1_ps(q.hi[axis])); };
        const auto high = [&](int axis) {
            return _mm_cmpge_ps(_mm_loadu_ps(v + 48 + 16 * axis), _mm_set1_ps(q.lo[axis]));
        };
        return static_cast<unsigned>(_mm_movemask_ps(_mm_and_ps(
            _mm_and_ps(_mm_and_ps(low(0), high(0)), _mm_and_ps(low(1), high(1))), _mm_and_ps(low(2), high(2)))));
    };
    return quarter(p) | quarter(p + 4) << 4 | quarter(p + 8) << 8 | quarter(p + 12) << 12;
#endif
}
inline unsigned hits(const AabbLevelView& level, std::uint32_t block, const Query& q)
{
    return hits(Block(level, block), q);
}

/// Pairs found while descending, from at most two nodes.
struct Found {
    std::uint32_t i[width * width + width], j[width * width + width], count = 0;
};

/// Appends (i, first + k) for each set bit k. Needs room for 16 pairs, even if fewer bits are set.
template <class List>
inline void append(List& list, std::uint32_t i, std::uint32_t first, unsigned bits)
{
#if defined(__AVX512F__)
    // No branch on the number of bits, which is unpredictable.
    const __m512i places = _mm512_add_epi32(_mm512_set1_epi32(static_cast<int>(first)),
                                            _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    _mm512_storeu_si512(list.i + list.count, _mm512_set1_epi32(static_cast<int>(i)));
    _mm512_storeu_si512(list.j + list.count, _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), places));
    list.count += static_cast<unsigned>(__builtin_popcount(bits));
#else
    for (; bits; bits &= bits - 1) {
        list.i[list.count] = i;
        list.j[list.count++] = first + static_cast<std::uint32_t>(__builtin_ctz(bits));
    }
#endif
}

inline void make_room(PairSink& sink)
{
    if (sink.count + 2 * width > sink.room) sink.more(sink);
}
inline void make_room(Found&) {} // always has room

/// Pairs of children, one of node a and one of node b of level `level`.
template <class List>
inline void expand(const AabbTreeView& tree, int level, std::uint32_t a, std::uint32_t b, List& list)
{
    const AabbLevelView& below = tree.level[level - 1];
    const std::uint32_t first_a = a * width, first_b = b * width;
    const unsigned moving_a = below.moving[a], moving_b = below.moving[b];
    unsigned of_a = hits(below, a, query_of(tree.level[level], b));
    if (!moving_b) of_a &= moving_a;
    const Block block_b(below, b);
    for (; of_a; of_a &= of_a - 1) {
        const auto k = static_cast<unsigned>(__builtin_ctz(of_a));
        unsigned of_b = hits(block_b, query_of(below, first_a + k));
        if (!(moving_a >> k & 1)) of_b &= moving_b;
        make_room(list);
        append(list, first_a + k, first_b, of_b);
    }
}

/// False if layers or groups forbid every pair of a body below node a and one below node b.
inline bool may_pair(const AabbLevelView& level, std::uint32_t a, std::uint32_t b)
{
    if (level.layers && !((level.layers[a] & level.masks[b]) && (level.layers[b] & level.masks[a]))) return false;
    return !level.groups || level.groups[a] != level.groups[b] || level.groups[a] == mixed_groups;
}

/// Pairs of boxes of level `stop`, one below node a and one below node b of level `level` > stop.
void between_nodes(const AabbTreeView& tree, int level, int stop, std::uint32_t a, std::uint32_t b, PairSink& sink)
{
    if (!may_pair(tree.level[level], a, b)) return;
    if (level - 1 == stop) return expand(tree, level, a, b, sink);
    Found found;
    expand(tree, level, a, b, found);
    for (std::uint32_t k = 0; k < found.count; ++k) between_nodes(tree, level - 1, stop, found.i[k], found.j[k], sink);
}

/// Pairs of children of one node.
template <class List>
inline void expand_within(const AabbLevelView& below, std::uint32_t node, List& list)
{
    const std::uint32_t first = node * width;
    const std::uint32_t count = below.count - first < width ? below.count - first : width;
    const unsigned moving = below.moving[node];
    const Block block(below, node);
    for (std::uint32_t k = 0; k < count; ++k) {
        unsigned others = hits(block, query_of(below, first + k)) & ~((2u << k) - 1);
        if (!(moving >> k & 1)) others &= moving;
        make_room(list);
        append(list, first + k, first, others);
    }
}

void within_node(const AabbTreeView& tree, int level, int stop, std::uint32_t node, PairSink& sink)
{
    if (level < tree.levels && !may_pair(tree.level[level], node, node)) return;
    const AabbLevelView& below = tree.level[level - 1];
    if (level - 1 == stop) return expand_within(below, node, sink);
    for (unsigned moving = below.moving[node]; moving; moving &= moving - 1)
        within_node(tree, level - 1, stop, node * width + static_cast<std::uint32_t>(__builtin_ctz(moving)), sink);
    Found found;
    expand_within(below, node, found);
    for (std::uint32_t k = 0; k < found.count; ++k) between_nodes(tree, level - 1, stop, found.i[k], found.j[k], sink);
}

inline Query query_at(const float box[6])
{
    return {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
}

inline void fetch(const AabbLevelView& level, std::uint32_t block)
{
    const float* p = level.blocks + std::size_t{block} * aabb_block;
    for (std::uint32_t line = 0; line < aabb_block; line += width) __builtin_prefetch(p + line);
}

void in_blocks(const AabbLevelView& level, const std::uint32_t* queries, const std::uint32_t* blocks,
               std::uint64_t count, const float* boxes, PairSink& sink)
{
    constexpr std::uint64_t ahead = 3; // blocks prefetched while one is compared
    for (std::uint64_t k = 0; k < count; ++k) {
        if (k + ahead < count) fetch(level, blocks[k + ahead]);
        make_room(sink);
        append(sink, queries[k], blocks[k] * width, hits(level, blocks[k], query_at(boxes + 6 * queries[k])));
    }
}

/// Finds boxes of level 0 below a node, as pairs (query, slot): hits(level, block) must select the box in its block,
/// and its nodes in the blocks above.
template <class Hits>
void below_node(const AabbTreeView& tree, int level, std::uint32_t node, std::uint32_t query, const Hits& hits,
                PairSink& sink)
{
    const AabbLevelView& below = tree.level[level - 1];
    const unsigned found = hits(below, node);
    if (level == 1) {
        make_room(sink);
        return append(sink, query, node * width, found);
    }
    const auto child = [&](unsigned bits) { return node * width + static_cast<std::uint32_t>(__builtin_ctz(bits)); };
    for (unsigned bits = found; bits; bits &= bits - 1) fetch(tree.level[level - 2], child(bits));
    for (unsigned bits = found; bits; bits &= bits - 1) below_node(tree, level - 1, child(bits), query, hits, sink);
}

void below_root(const AabbTreeView& tree, std::uint32_t query, const float box[6], PairSink& sink)
{
    const Query around = query_at(box);
    const auto in_box = [&](const AabbLevelView& level, std::uint32_t block) { return hits(level, block, around); };
    if (tree.levels > 0) below_node(tree, tree.levels, 0, query, in_box, sink);
}

/// Bit k is set if the segment may meet box k of the block.
unsigned hits_on(const AabbLevelView& level, std::uint32_t block, const SegmentLine& s)
{
    const float* const p = level.blocks + std::size_t{block} * aabb_block;
    const auto half = [&](const float* v) {
        F32x8 to[3], wide[3];
        I32x8 meets;
        for (int axis = 0; axis < 3; ++axis) {
            const F32x8 lo = load(v + 16 * axis), hi = load(v + 48 + 16 * axis);
            to[axis] = 0.5f * (lo + hi) - s.middle[axis];
            wide[axis] = 0.5f * (hi - lo) + s.error + 0x1p-20f * (abs(lo) + abs(hi)); // a box may be very large
            const I32x8 near = abs(to[axis]) <= wide[axis] + s.half * __builtin_fabsf(s.direction[axis]);
            meets = axis ? meets & near : near;
        }
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3;
            const float of_i = s.direction[i], of_j = s.direction[j];
            meets &= abs(to[i] * of_j - to[j] * of_i) <=
                     wide[i] * __builtin_fabsf(of_j) + wide[j] * __builtin_fabsf(of_i) + s.cross_error;
        }
        return bits(meets); // the centres of the empty boxes that pad the block are NaN, which fails
    };
    return half(p) | half(p + 8) << 8;
}

void on_segment(const AabbTreeView& tree, std::uint32_t query, const SegmentLine& segment, PairSink& sink)
{
    const auto on = [&](const AabbLevelView& level, std::uint32_t block) { return hits_on(level, block, segment); };
    if (tree.levels > 0) below_node(tree, tree.levels, 0, query, on, sink);
}

float least(F32x8 v)
{
    v = min(v, ONCOLLIDE_SHUFFLE(v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = min(v, ONCOLLIDE_SHUFFLE(v, 2, 3, 0, 1, 6, 7, 4, 5));
    v = min(v, ONCOLLIDE_SHUFFLE(v, 1, 0, 3, 2, 5, 4, 7, 6));
    return v[0];
}

void bound(const AabbLevelView& below, std::uint32_t node, float box[6])
{
    const float* p = below.blocks + std::size_t{node} * aabb_block;
    for (int axis = 0; axis < 3; ++axis) {
        const float *lo = p + 16 * axis, *hi = lo + 48;
        box[axis] = least(min(load(lo), load(lo + 8)));
        box[3 + axis] = -least(-max(load(hi), load(hi + 8)));
    }
}

// The nodes of the top level are the children of a virtual root, node 0 of level `levels`.

void all(const AabbTreeView& tree, int stop, PairSink& sink)
{
    within_node(tree, tree.levels, stop, 0, sink);
}

void within(const AabbTreeView& tree, int level, std::uint32_t node, PairSink& sink)
{
    if (tree.level[level].moving[node / width] >> node % width & 1) within_node(tree, level, 0, node, sink);
}

void between(const AabbTreeView& tree, int level, std::uint32_t a, std::uint32_t b, PairSink& sink)
{
    between_nodes(tree, level, 0, a, b, sink);
}

} // namespace

AabbTreeKernel aabb_tree_kernel()
{
    return {all, within, between, in_blocks, below_root, on_segment, bound};
}

} // namespace oncollide::ONCOLLIDE_ISA
