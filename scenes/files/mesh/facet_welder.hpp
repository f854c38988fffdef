#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/large_vector.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// Welder for the facets of binary STL, many at once: equal corners get one number, in order of first use. Beside the
/// points it takes 6 to 13 bytes a point and at most 0.5 MB. Private to scenes.
class FacetWelder {
public:
    static constexpr std::size_t facet_bytes = 50, corners_at = 12; ///< of a facet; three corners of three floats
    static constexpr std::size_t batch = 64;                        ///< facets at once, at most
    static constexpr std::size_t bytes_behind = 2;                  ///< that may be read after the last facet

    explicit FacetWelder(std::size_t facets);
    /// The corners of up to `batch` facets as they lie in the file. False where one is not finite: that is the end.
    bool add(const char* facets, std::size_t count, Triangle* triangles);
    std::vector<Eigen::Vector3d> take() { return std::move(points_); }

private:
    /// The bits of a point, the same for both zeros.
    struct [[gnu::packed]] Key {
        std::uint64_t xy;
        std::uint32_t z;
        bool operator==(const Key& other) const { return (xy == other.xy) & (z == other.z); }
    };
    struct Recent {
        Key key;
        std::uint32_t number;
    };
    /// Of one hash, the last found comes first.
    struct alignas(64) RecentLine {
        std::array<Recent, 4> entries;
        bool begins_with(const Key& key) const { return entries[0].key == key; }
        /// Moves it to the front; false, and nothing is done, where it is missing.
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
    /// A power of two of them, at most five in eight in use: 0, or 1 + a number in the low bits and bits of the hash in
    /// the others, so that few points are looked at in vain.
    LargeVector<std::uint32_t> slots_;
    bool many_known_ = false;        ///< of those that were missing last: they are looked up in points_
    std::uint32_t mask_ = 0;         ///< of a number in a slot
    std::vector<RecentLine> recent_; ///< by hash: in most files nearly all corners are here
    int recent_shift_;
    std::vector<Corner> corners_;                ///< of the batch
    std::vector<std::uint32_t> missing_, found_; ///< of its corners, those that are not recent, and their numbers
};

} // namespace oncollide
