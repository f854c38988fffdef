#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// What delimitation did at one level of its region hierarchy, level 0 being the whole scene.
struct DelimitationLevel {
    std::uint64_t regions = 0;          ///< regions looked at
    std::uint64_t regions_rejected = 0; ///< of these, regions in which nothing can collide
    std::uint64_t bodies_rejected = 0;  ///< bodies in them (a body that straddles regions counts in each)
    double volume_rejected = 0;         ///< share of the scene's volume that they cover, 0 to 1
};

/// Progressive delimitation: a hierarchy of regions that tile space, split by planes that cut as few bodies as
/// possible, so that neighbouring regions overlap least. A region with no moving body, with one body alone, or in which
/// the layers forbid every pair is rejected whole, at the highest level where that shows, and nothing below it is
/// looked at.
///
/// The hierarchy and the static bodies in it stay from frame to frame; only movers are placed anew. It is built again
/// when movers have gathered so much that regions no longer tell them apart.
/// Cost of a frame: O(movers * depth), whatever the number of static bodies. Building: O(n log^2 n).
/// Source: Franquesa-Niubó and Brunet, "Collision prediction using MKtrees", CEIG 2004.
class Delimitation {
public:
    /// Why delimitation would not pay for itself on such a scene; empty when it may.
    static std::string_view reason_to_skip(const BodyFilter& filter);

    /// @param boxes      world boxes by body
    /// @param margin     metres by which boxes are grown in all (half on each side); >= 0
    /// @param survivors  overwritten: the bodies of the regions that are left, ascending, each once. Every allowed pair
    /// of
    ///                   bodies whose grown boxes overlap is among them.
    void run(std::span<const Aabb> boxes, const BodyFilter& filter, double margin,
             std::vector<std::uint32_t>& survivors);

    /// Of the last run, by level.
    std::span<const DelimitationLevel> levels() const { return levels_; }

private:
    struct Region {
        double plane = 0;
        std::int32_t axis = -1;              ///< -1: a leaf
        std::uint32_t children = 0;          ///< low side; the high side is the next one
        std::uint32_t first = 0, count = 0;  ///< leaf: its static bodies, in static_bodies_
        std::uint32_t statics = 0;           ///< static bodies in it
        std::uint32_t layers = 0, masks = 0; ///< of its static bodies, or-ed
        double volume = 0;                   ///< share of the scene's
    };

    void build(std::span<const Aabb> boxes, const BodyFilter& filter, double margin);
    void split(std::uint32_t region, std::vector<std::uint32_t>& bodies, const Aabb& space, int depth,
               std::span<const Aabb> boxes, const BodyFilter& filter, double margin);
    void visit(std::uint32_t region, std::size_t level, std::size_t first_mover, std::span<const Aabb> boxes,
               const BodyFilter& filter, double half_margin, std::vector<std::uint32_t>& survivors);

    std::vector<Region> regions_;
    std::vector<std::uint32_t> static_bodies_;
    std::vector<std::uint32_t> movers_;     ///< stack: the movers of the regions on the way down
    std::vector<std::uint32_t> mover_list_; ///< every mover of the scene
    std::vector<std::uint8_t> survives_;
    std::vector<DelimitationLevel> levels_;
    std::vector<double> ends_;                         ///< scratch of split
    std::uint64_t placed_ = 0, placed_when_built_ = 0; ///< movers in surviving leaves
    bool built_ = false;
};

} // namespace oncollide
