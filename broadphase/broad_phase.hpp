#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>

namespace oncollide {

/// Two bodies that may collide; a < b.
struct BodyPair {
    std::uint32_t a, b;
    friend bool operator==(BodyPair, BodyPair) = default;
    friend auto operator<=>(BodyPair, BodyPair) = default;
};

/// The bodies' data that a broad phase reads: columns owned by the caller, indexed by body.
struct BodyColumns {
    std::span<const Aabb> boxes; ///< world, metres, closed: boxes that touch overlap
    /// Bits. Two bodies may form a pair if the layers of each meet the mask of the other. Both empty: no pair is
    /// forbidden.
    std::span<const std::uint32_t> layers{}, masks{};
    /// Two bodies of the same group other than 0 never form a pair. Empty: all bodies are in group 0.
    std::span<const std::uint32_t> groups{};
    /// Must change whenever a layer, a mask or a group changes: filters are compared only if it changed. 0: not
    /// tracked, so filters are always compared.
    std::uint64_t filters_version = 0;

    /// True if layers, masks and groups allow this pair.
    bool allows(std::uint32_t a, std::uint32_t b) const
    {
        if (!layers.empty() && !((layers[a] & masks[b]) && (layers[b] & masks[a]))) return false;
        return groups.empty() || groups[a] == 0 || groups[a] != groups[b];
    }
};

/// A query's box overlaps a body's box.
struct AabbHit {
    std::uint32_t query, body; ///< index of the box in the query; the body
    friend bool operator==(AabbHit, AabbHit) = default;
    friend auto operator<=>(AabbHit, AabbHit) = default;
};

/// Statistics of progressive delimitation at one level of its hierarchy of regions; level 0 is the whole scene. Counts
/// only regions whose parent was not rejected.
struct DelimitationLevel {
    std::uint64_t regions = 0;          ///< regions examined
    std::uint64_t regions_rejected = 0; ///< regions among them in which no pair can collide
    std::uint64_t bodies_rejected = 0;  ///< bodies in the rejected regions
    double volume_rejected = 0;         ///< rejected share of the volume of all the level's regions, 0 to 1
    double ms = 0;                      ///< time spent on the level
};

/// One region that progressive delimitation examined.
struct DelimitedRegion {
    Aabb box;      ///< around the bodies in it, metres, rounded outward
    int level;     ///< 0 is the whole scene
    bool rejected; ///< no pair in it can collide
};

/// Tracks bodies that are added, removed and moved, and finds the pairs whose boxes overlap. Results are kept between
/// frames, so a frame costs in proportion to the changes, not to the number of bodies.
///
///     const auto broad = make_kd_tree({.threads = 2});
///     broad->add(bodies);                                          // any number of changes, in bulk
///     broad->move(moved);
///     for (BodyPair pair : broad->find_pairs({.boxes = boxes})) ... // all pairs there are now
///
/// Bodies are rows of the caller's columns. A static body forms pairs with dynamic bodies only; a body stays static or
/// dynamic until make_dynamic() or make_static(). After a body's box, layers, mask or group change, call move().
class ONCOLLIDE_API BroadPhase {
public:
    struct Options {
        double margin = 0; ///< metres, >= 0: each box is grown by half of this on all sides before comparison
        int threads = 1;   ///< >= 1; never changes a result
    };

    virtual ~BroadPhase() = default;
    virtual std::string_view name() const = 0;

    // List each body at most once per call. All throw Error{usage} naming the body, and then change nothing: add() if
    // the body is already present, the others if it is not.
    virtual void add(std::span<const std::uint32_t> bodies, bool is_static = false) = 0;
    virtual void remove(std::span<const std::uint32_t> bodies) = 0;
    virtual void move(std::span<const std::uint32_t> bodies) = 0;
    virtual void make_static(std::span<const std::uint32_t> bodies) = 0;
    virtual void make_dynamic(std::span<const std::uint32_t> bodies) = 0;

    /// Applies pending changes, as query() requires; find_pairs() and delimit() start with this call.
    /// Throws Error{bad_data} naming a body whose box is not finite or exceeds 1e30 m, Error{usage} for columns that
    /// are too short. Pending changes are then kept: correct the columns and call again.
    virtual void take_in(const BodyColumns& columns) = 0;

    /// All pairs of bodies whose boxes overlap, that are not both static and that the columns allow; sorted, each once.
    /// Independent of the thread count. Valid until the next call that is not const. Boxes are compared in float,
    /// rounded outward, and where that is inconclusive in double. Throws the errors of take_in(). Allocates no memory
    /// once warm.
    /// @param whole  search among all bodies, instead of only in the regions near changed bodies
    virtual std::span<const BodyPair> find_pairs(const BodyColumns& columns, bool whole = false) = 0;

    // Access to the results of progressive delimitation. Without delimitation (brute force, or if most bodies changed
    // and everything is searched) there are no levels, and all bodies are left.
    /// The first half of find_pairs(), which calls it if necessary: applies the changes and finds the regions in which
    /// a pair may have appeared or disappeared. Throws the errors of take_in().
    virtual void delimit(const BodyColumns& columns) { take_in(columns); }
    /// Statistics of the last delimit(), level by level. Counted on request; empty once a later change was applied.
    virtual std::span<const DelimitationLevel> levels() { return {}; }
    /// The regions that levels() counts, level by level, for display. Empty if levels() is.
    virtual std::vector<DelimitedRegion> regions() { return {}; }
    /// The number of bodies in regions that are not rejected.
    virtual std::uint64_t bodies_left() { return size(); }
    /// Overwrites `bodies` with these bodies and with the bodies that were near changed bodies before the change;
    /// ascending. Contains both bodies of every pair with a changed body.
    virtual void survivors(std::vector<std::uint32_t>& bodies) = 0;

    /// Bodies whose boxes, grown by the margin in all, overlap each of `boxes`, regardless of layers, masks, groups and
    /// static state; sorted. Overwrites `hits`; allocates only for its elements. Safe from many threads while nothing
    /// changes.
    /// Throws Error{usage} if changes are pending, Error{bad_data} naming a box that is not finite or exceeds 1e30 m.
    /// @param columns  the columns as they were when the changes were applied
    virtual void query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<AabbHit>& hits) const = 0;

    /// The same for segments: the bodies whose boxes, grown by the margin in all, meet each of `segments`. Rounding may
    /// add bodies that a segment just misses. Throws Error{bad_data} naming a segment that is not finite or exceeds
    /// 1e30 m.
    virtual void query_segments(const BodyColumns& columns, std::span<const Segment> segments,
                                std::vector<AabbHit>& hits) const = 0;

    virtual std::size_t size() const = 0; ///< bodies
    virtual bool contains(std::uint32_t body) const = 0;
    virtual std::size_t bytes() const = 0; ///< memory kept between calls
};

// All throw Error{usage} for options out of range.

/// kd-tree: boxes in kd order under an implicit 16-ary tree of bounds. The tree stores enlarged boxes of moving bodies;
/// a body that leaves its enlarged box is searched for in the regions near it. The whole tree is searched when over a
/// quarter of the bodies leave theirs, or when the tree has become loose.
/// Cost of find_pairs(): O(changed + pairs), about a microsecond per body that left its enlarged box and a tenth per
/// other changed body; O(n) for a search of the whole tree. Cost of query(): about a microsecond per box or segment.
/// Memory: 45 bytes per body, 70 per body that moved, and 8 to 40 per pair, not counting forbidden pairs.
ONCOLLIDE_API std::unique_ptr<BroadPhase> make_kd_tree(const BroadPhase::Options& options = {});

/// Octree: the same tree with boxes in the order of an octree's cells. Building costs a third of the kd-tree's,
/// searching somewhat more: better for bodies that jump.
ONCOLLIDE_API std::unique_ptr<BroadPhase> make_octree(const BroadPhase::Options& options = {});

/// Compares every pair of boxes. The reference. Cost: O(n^2), a query O(n).
ONCOLLIDE_API std::unique_ptr<BroadPhase> make_brute_force(const BroadPhase::Options& options = {});

} // namespace oncollide
