// Compiled once per instruction set; see oncollide_add_kernel.
//
// A fan is projected along the sum of its normals. Let all of its triangles be counter-clockwise around the vertex, and
// let every edge from the vertex end one triangle and begin another one. Then the same number of triangles covers every
// direction between edges, and the triangles that end in one direction have the edges of the triangles that begin
// there. If one triangle covers some direction, the fan is spread out.
//
// Edges are differences of doubles, scaled to about 1 and rounded to floats. The test needs signs of sums of products.
// At most eight roundings by 2^-24 enter each of these sums; the bounds have twice as many.
#include <cstddef>

#include <oncollide/base/simd/simd.hpp>
#include <oncollide/narrowphase/self/fan_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

constexpr float rounding = 0x1p-20f;
/// Covers underflow where no edge is longer than `longest`.
constexpr float least = 0x1p-100f, longest = 0x1p16f;
/// A direction that edges of meshes with axes do not have.
constexpr float aside[3] = {0.31830989f, 0.57721566f, 0.77151834f};

using F64x4 = double __attribute__((vector_size(32)));
using F32x4 = float __attribute__((vector_size(16)));

inline float magnitude(float x)
{
    return __builtin_fabsf(x);
}

inline float sum(F32x8 v)
{
    v += ONCOLLIDE_SHUFFLE(v, 4, 5, 6, 7, 0, 1, 2, 3);
    v += ONCOLLIDE_SHUFFLE(v, 2, 3, 0, 1, 6, 7, 4, 5);
    v += ONCOLLIDE_SHUFFLE(v, 1, 0, 3, 2, 5, 4, 7, 6);
    return v[0];
}

inline F32x8 where(I32x8 mask, F32x8 v)
{
    return reinterpret_cast<F32x8>(reinterpret_cast<I32x8>(v) & mask);
}

inline I32x8 splat(std::uint32_t x)
{
    return I32x8{} + static_cast<std::int32_t>(x);
}

/// The lanes of v with these numbers.
inline F32x8 permuted(F32x8 v, I32x8 numbers)
{
#if defined(__AVX2__)
    return reinterpret_cast<F32x8>(
        _mm256_permutevar8x32_ps(reinterpret_cast<__m256>(v), reinterpret_cast<__m256i>(numbers)));
#else
    F32x8 all;
    for (int lane = 0; lane < 8; ++lane) all[lane] = v[numbers[lane]];
    return all;
#endif
}

/// The fan of one vertex, of at most 8 * `groups` triangles, one per lane. All loops are over all lanes, as ends that
/// depend on the fan would be unpredictable, and nothing is written to memory to be read in other pieces.
template <unsigned groups>
class Fan {
public:
    /// @param count  of triangles, 3 to 8 * `groups`
    bool is_spread(const FansOfVertices& fans, std::uint32_t vertex, unsigned count)
    {
        const std::uint32_t* const first = fans.first + fans.begin[vertex];
        for (unsigned g = 0; g < groups; ++g)
            there_[g] =
                I32x8{0, 1, 2, 3, 4, 5, 6, 7} < static_cast<std::int32_t>(count) - static_cast<std::int32_t>(8 * g);
        return is_closed(first, fans.second + fans.begin[vertex], count) && take_edges(fans.vertices, vertex, first) &&
               goes_round_once();
    }

private:
    /// True if every second edge is the first edge of exactly one triangle, and the reverse.
    bool is_closed(const std::uint32_t* first, const std::uint32_t* second, unsigned count)
    {
        I32x8 seconds[groups], matches[groups];
        __builtin_memcpy(seconds, second, sizeof seconds);
        for (unsigned g = 0; g < groups; ++g) matches[g] = next_[g] = I32x8{};
        unsigned matched = 0; // first edges
#pragma GCC unroll 8
        for (unsigned i = 0; i < 8 * groups; ++i) {
            const std::uint32_t of = i < count ? first[i] : 0xffffffff; // beyond the fan: edges of other vertices
            I32x8 any{};
            for (unsigned g = 0; g < groups; ++g) {
                const I32x8 same = (seconds[g] == splat(of)) & there_[g];
                matches[g] -= same, next_[g] |= same & splat(i), any |= same;
            }
            matched |= unsigned(bits(any) != 0) << i;
        }
        unsigned once = 0;
        for (unsigned g = 0; g < groups; ++g) once |= bits(matches[g] == 1) << 8 * g;
        const unsigned full = (1u << count) - 1;
        return matched == full && once == full;
    }
    /// Sets the edges, relative to the length of one of them.
    bool take_edges(const double* vertices, std::uint32_t vertex, const std::uint32_t* first)
    {
        const double *const at = vertices + std::size_t{3} * vertex, *const to = vertices + std::size_t{3} * first[0];
        const double size =
            __builtin_fabs(to[0] - at[0]) + __builtin_fabs(to[1] - at[1]) + __builtin_fabs(to[2] - at[2]);
        if (!(size > 1e-290)) return false;
        const double scale = 1 / size;
        for (unsigned g = 0; g < groups; ++g) {
            const double* ends[8];
#pragma GCC unroll 8
            for (unsigned k = 0; k < 8; ++k) ends[k] = vertices + std::size_t{3} * first[8 * g + k];
            for (unsigned c = 0; c < 3; ++c) {
                const F64x4 low{ends[0][c], ends[1][c], ends[2][c], ends[3][c]},
                    high{ends[4][c], ends[5][c], ends[6][c], ends[7][c]};
                const F32x4 edges[2] = {__builtin_convertvector((low - at[c]) * scale, F32x4),
                                        __builtin_convertvector((high - at[c]) * scale, F32x4)};
                F32x8 both;
                __builtin_memcpy(&both, edges, sizeof both);
                first_[c][g] = where(there_[g], both);
            }
        }
        for (unsigned c = 0; c < 3; ++c)
            for (unsigned g = 0; g < groups; ++g) second_[c][g] = where(there_[g], next_of(first_[c], g));
        return true;
    }
    /// For each triangle of group g, the value of the next triangle.
    F32x8 next_of(const F32x8 (&values)[groups], unsigned g) const
    {
        F32x8 all = permuted(values[0], next_[g] & 7);
        for (unsigned h = 1; h < groups; ++h) {
            const I32x8 in_h = (next_[g] >> 3) == static_cast<std::int32_t>(h);
            all = where(~in_h, all) + where(in_h, permuted(values[h], next_[g] & 7));
        }
        return all;
    }
    bool goes_round_once() const
    {
        F32x8 normals[3][groups], bounds[groups], lengths[groups], behind[groups];
        float along[3] = {0, 0, 0}, left[3];
        for (unsigned g = 0; g < groups; ++g) {
            for (unsigned c = 0; c < 3; ++c) {
                const unsigned d = (c + 1) % 3, e = (c + 2) % 3;
                normals[c][g] = first_[d][g] * second_[e][g] - first_[e][g] * second_[d][g];
                along[c] += sum(normals[c][g]);
            }
            lengths[g] = abs(first_[0][g]) + abs(first_[1][g]) + abs(first_[2][g]);
            bounds[g] = lengths[g] * (abs(second_[0][g]) + abs(second_[1][g]) + abs(second_[2][g]));
        }
        const float length = magnitude(along[0]) + magnitude(along[1]) + magnitude(along[2]);
        for (unsigned c = 0; c < 3; ++c) {
            const unsigned d = (c + 1) % 3, e = (c + 2) % 3;
            left[c] = aside[d] * along[e] - aside[e] * along[d];
        }
        I32x8 fails{}, before[groups]; // before, behind: first edges, as seen from `aside`
        for (unsigned g = 0; g < groups; ++g) {
            const F32x8 turn = normals[0][g] * along[0] + normals[1][g] * along[1] + normals[2][g] * along[2];
            const F32x8 side = first_[0][g] * left[0] + first_[1][g] * left[1] + first_[2][g] * left[2];
            const F32x8 bound = rounding * length * lengths[g] + least;
            before[g] = side > bound, behind[g] = reinterpret_cast<F32x8>(side < -bound);
            const I32x8 certain = (turn > rounding * length * bounds[g] + least) & (lengths[g] < longest) &
                                  (before[g] | reinterpret_cast<I32x8>(behind[g]));
            fails |= there_[g] & ~certain;
        }
        if (bits(fails)) return false;
        unsigned covering = 0; // triangles that cover the direction of `aside`
        for (unsigned g = 0; g < groups; ++g)
            covering |= bits(before[g] & there_[g] & reinterpret_cast<I32x8>(next_of(behind, g))) << 8 * g;
        return covering && !(covering & (covering - 1));
    }

    I32x8 there_[groups];                        ///< lanes with a triangle; the edges of other lanes are 0
    I32x8 next_[groups];                         ///< the triangle whose first edge is the second edge of this one
    F32x8 first_[3][groups], second_[3][groups]; ///< edges
};

void spread_fans(const FansOfVertices& fans, std::uint32_t from, std::uint32_t to, std::uint8_t* spread)
{
    for (std::uint32_t v = from; v < to; ++v) {
        const unsigned count = fans.begin[v + 1] - fans.begin[v];
        spread[v] = count < 3    ? 0
                    : count <= 8 ? Fan<1>().is_spread(fans, v, count)
                                 : count <= 16 && Fan<2>().is_spread(fans, v, count);
    }
}

} // namespace

SpreadFans* spread_fans_kernel()
{
    return spread_fans;
}

} // namespace oncollide::ONCOLLIDE_ISA
