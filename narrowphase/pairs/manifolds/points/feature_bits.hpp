// The bits of features: the two highest are 1, 2 or 3 for a vertex, an edge or a face.
#pragma once
#include <utility>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/finding.hpp>

namespace oncollide {

/// @param number  below 2^62
constexpr FeatureBits vertex_feature(std::uint64_t number)
{
    return FeatureBits{1} << 62 | number;
}
/// @param hash  of the edge; its two lowest bits are dropped
constexpr FeatureBits edge_feature(std::uint64_t hash)
{
    return FeatureBits{2} << 62 | hash >> 2;
}
/// The edge between two vertices, in any order; see edge_vertices().
inline FeatureBits edge_feature(std::uint32_t from, std::uint32_t to)
{
    if (from > to) std::swap(from, to);
    if (to >> 31 != 0) return edge_feature(splitmix(std::uint64_t{from} << 32 | to));
    return FeatureBits{2} << 62 | FeatureBits{from} << 31 | to;
}
constexpr FeatureBits face_feature(std::uint64_t number)
{
    return FeatureBits{3} << 62 | number;
}
/// A box's face across an axis: the number of its first triangle, as in box_corners.hpp.
constexpr FeatureBits box_face_feature(int axis, bool high)
{
    return face_feature(static_cast<std::uint64_t>(4 * (2 - axis) + 2 * int{high}));
}

} // namespace oncollide
