#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>

namespace oncollide {

/// The triangle lists of one tree in one arena: 5 bytes per entry, 8 per list. Released lists leave holes; when holes
/// fill half of the arena, it is packed.
class TriangleLists {
public:
    ListId add(const std::uint32_t* ids, const std::uint8_t* masks, std::uint32_t count);
    void release(ListId list);
    /// The triangles of `list` that enter `octant` of its cell.
    TriangleSpan span(ListId list, unsigned octant) const;
    std::size_t bytes() const;

private:
    struct List {
        std::uint32_t offset, count;
    };
    void pack();

    std::vector<std::uint32_t> ids_;
    std::vector<std::uint8_t> masks_;
    std::vector<List> lists_;
    std::vector<std::uint32_t> free_; ///< released list numbers
    std::size_t holes_ = 0;
};

} // namespace oncollide
