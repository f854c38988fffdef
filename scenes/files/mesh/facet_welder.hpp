#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// Welder for the facets of binary STL, in batches: equal corners get one number, in order of first use. In addition to
/// the points it takes 6 to 13 bytes per point and at most 0.5 MB. Private to scenes.
class FacetWelder {
public:
    static constexpr std::size_t facet_bytes = 50, corners_at = 12; ///< sizes of a facet; three corners of three floats
    static constexpr std::size_t batch = 64;                        ///< most facets per call
    static constexpr std::size_t bytes_behind = 2;                  ///< bytes that are readable after the last facet

    explicit FacetWelder(std::size_t facets);
    /// Adds the corners of up to `batch` facets in the layout of the file. Returns false if a coordinate is not finite;
    /// the mesh is then invalid.
    bool add(const char* facets, std::size_t count, Triangle* triangles);
    std::vector<Eigen::Vector3d> take() { return std::move(points_); }

private:
    /// The bits of a point; -0 becomes 0.
    struct [[gnu::packed]] Key {
        std::uint64_t xy;
        std::uint32_t z;
        bool operator==(const Key& other) const { return (xy == other.xy) & (z == other.z); }
    };
    struct Recent {
        Key key;
        std::uint32_t number;
    };
    /// The most recent points of one hash, the latest first.
    struct alignas(64) RecentLine {
        std::array<Recent, 4> entries;
        bool begins_with(const Key& key) const { return entries[0].key == key; }
        /// Moves the entry to the front; returns false and does nothing if it is missing.
        bool bring_forward(const Key& key);
        void insert(const Recent& entry);
    };
    struct Corner {
        Key key;
        std::uint64_t hash;
    };

    static Key key_at(const char* corner);
    static std::uint64_t hash_of(const Key& key);
    void take_apart(const char* facets, std::size_t count);
    std::uint32_t look_among_recent(std::size_t corners, std::uint32_t* numbers);
    template <class IsIt>
    std::size_t place_of(std::uint64_t hash, IsIt is_it) const;
    std::uint32_t tag_of(std::uint64_t hash) const;
    void fetch_points(std::size_t missing) const;
    void make_slots(std::size_t count);
    void correct(std::uint32_t missing, std::uint32_t first_new, std::span<std::uint32_t> numbers);

    std::vector<Eigen::Vector3d> points_;
    /// A power of two, at most five in eight in use: 0, or 1 + a point's number in the low bits and bits of its hash in
    /// the others, so that few points are compared in vain.
    LargeVector<std::uint32_t> slots_;
    bool many_known_ = false;        ///< over an eighth of the corners missing in recent_ were in points_, in the
                                     ///< last batch: prefetch points_
    std::uint32_t mask_ = 0;         ///< mask of the number in a slot
    std::vector<RecentLine> recent_; ///< by hash; in most files nearly all corners are found here
    int recent_shift_;
    std::vector<Corner> corners_;                ///< corners of the batch
    std::vector<std::uint32_t> missing_, found_; ///< corners of the batch that are not in recent_, and their numbers
};

} // namespace oncollide
