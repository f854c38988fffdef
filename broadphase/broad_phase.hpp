#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/base/aabb.hpp>

namespace oncollide {

/// Two bodies that may collide; a < b.
struct BodyPair {
    std::uint32_t a, b;
    friend bool operator==(BodyPair, BodyPair) = default;
    friend auto operator<=>(BodyPair, BodyPair) = default;
};

/// What a broad phase reads of the bodies: columns of the caller's, rows by body.
struct BodyColumns {
    std::span<const Aabb> boxes; ///< world, metres, closed: boxes that touch overlap
    /// Bits. Two bodies may form a pair if each one's layers meet the other's mask. Both empty: no pair is forbidden.
    std::span<const std::uint32_t> layers{}, masks{};
    /// Two bodies of one group other than 0 never form a pair. Empty: all are of group 0.
    std::span<const std::uint32_t> groups{};
    /// Another number whenever a layer, a mask or a group has changed: while it stays, nobody looks whether one has.
    /// 0: not counted.
    std::uint64_t filters_version = 0;

    /// Do layers, masks and groups allow this pair?
    bool allows(std::uint32_t a, std::uint32_t b) const
    {
        if (!layers.empty() && !((layers[a] & masks[b]) && (layers[b] & masks[a]))) return false;
        return groups.empty() || groups[a] == 0 || groups[a] != groups[b];
    }
};

/// A box of a query overlaps the box of a body.
struct BoxHit {
    std::uint32_t query, body; ///< number of the box in the query; the body
    friend bool operator==(BoxHit, BoxHit) = default;
    friend auto operator<=>(BoxHit, BoxHit) = default;
};

/// What progressive delimitation did at one level of its hierarchy of regions, level 0 being the whole scene. A region
/// counts where the one around it was not rejected.
struct DelimitationLevel {
    std::uint64_t regions = 0;          ///< regions looked at
    std::uint64_t regions_rejected = 0; ///< of these, regions in which nothing can collide
    std::uint64_t bodies_rejected = 0;  ///< bodies in them
    double volume_rejected = 0;         ///< share of the volume of all the level's regions out of play, 0 to 1
    double ms = 0;                      ///< time spent on the level
};

/// One region that progressive delimitation looked at.
struct DelimitedRegion {
    Aabb box;      ///< around the bodies in it, metres, rounded outward
    int level;     ///< 0 is the whole scene
    bool rejected; ///< nothing in it can collide
};

/// Bodies that come, go, move and rest, and which of their boxes overlap, kept from frame to frame: a frame costs what
/// changed in it, not what exists.
///
///     const auto broad = make_kd_tree({.threads = 2});
///     broad->add(bodies);                                          // any number of changes, in bulk
///     broad->move(moved);
///     for (BodyPair pair : broad->find_pairs({.boxes = boxes})) ... // all pairs there are now
///
/// Bodies are rows of the caller's columns. A static body forms pairs with dynamic bodies only; a body
/// stays static or dynamic until make_dynamic() or make_static(). After a change of its box, layers, mask or group, call move().
class BroadPhase {
public:
    struct Options {
        double margin = 0; ///< metres, >= 0: boxes are grown by half of it on all sides before they are compared
        int threads = 1;   ///< >= 1; never changes a result
    };

    virtual ~BroadPhase() = default;
    virtual std::string_view name() const = 0;

    // Each body at most once per call. All throw Error{usage} naming the body and then have changed nothing: add() if
    // the body is there already, the others if it is not.
    virtual void add(std::span<const std::uint32_t> bodies, bool is_static = false) = 0;
    virtual void remove(std::span<const std::uint32_t> bodies) = 0;
    virtual void move(std::span<const std::uint32_t> bodies) = 0;
    virtual void make_static(std::span<const std::uint32_t> bodies) = 0;
    virtual void make_dynamic(std::span<const std::uint32_t> bodies) = 0;

    /// Takes in the changes, so that query() is current; find_pairs() and delimit() begin with it.
    /// Throws Error{bad_data} naming a body whose box is not finite or beyond 1e30 m, Error{usage} for columns that are
    /// too short. Then no change is lost: mend the columns and call again.
    virtual void take_in(const BodyColumns& columns) = 0;

    /// Pairs of bodies whose boxes overlap now, not both static, that the columns allow; sorted, each once. The same
    /// for any number of threads. Valid until the next call that is not const. Boxes are compared in float, rounded
    /// outward, and in double where that leaves a doubt. Errors as take_in(). Allocates nothing once warm.
    /// @param whole  search among all bodies, whatever changed, instead of in the regions that the changed ones reach
    virtual std::span<const BodyPair> find_pairs(const BodyColumns& columns, bool whole = false) = 0;

    // Progressive delimitation, for those that want to see it; without it (brute force, or where so much changed that
    // all is searched) there are no levels and all bodies are left.
    /// The first half of find_pairs(), which does it if need be: takes in the changes and finds the regions in which a
    /// pair may have come or gone. Errors as take_in().
    virtual void delimit(const BodyColumns& columns) { take_in(columns); }
    /// What the last delimit() did, level by level. Counted on request; empty once a later change was taken in.
    virtual std::span<const DelimitationLevel> levels() { return {}; }
    /// The regions that levels() counts, level by level, to look at. Empty where levels() are.
    virtual std::vector<DelimitedRegion> regions() { return {}; }
    /// Bodies in the regions that are left.
    virtual std::uint64_t bodies_left() { return size(); }
    /// Overwrites `bodies` with them, and with those that were near bodies that changed before; ascending. Every pair
    /// that a changed body is in is among them.
    virtual void survivors(std::vector<std::uint32_t>& bodies) = 0;

    /// Bodies whose boxes, grown by the margin in all, overlap each of `boxes`, whatever their layers, group and sleep;
    /// sorted. Overwrites `hits`, and allocates nothing but what these need. Safe from many threads at once while
    /// nothing is changed.
    /// Throws Error{usage} if changes have not been taken in, Error{bad_data} naming a box that is not finite or beyond
    /// 1e30 m.
    /// @param columns  as they were when the changes were taken in
    virtual void query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<BoxHit>& hits) const = 0;

    virtual std::size_t size() const = 0; ///< bodies
    virtual bool contains(std::uint32_t body) const = 0;
    virtual std::size_t bytes() const = 0; ///< held from call to call
};

// All throw Error{usage} for options out of range.

/// kd-tree: boxes in kd order under an implicit 16-ary tree of bounds. It holds somewhat larger boxes of bodies that
/// move, and what leaves these is searched in the regions that it reaches; where over a quarter does, and now and then
/// when the tree has become loose, all is.
/// Cost of find_pairs(): O(changed + pairs), about a microsecond per body that left its larger box and a tenth per body
/// that did not, O(n) where all is searched; of query(): about a microsecond per box. Memory: 45 bytes per body, 70 per
/// body that moved, and 8 to 40 per pair, not counting pairs forbidden.
std::unique_ptr<BroadPhase> make_kd_tree(const BroadPhase::Options& options = {});

/// Octree: the same tree over boxes in the order of an octree's cells. Its order costs a third of the kd-tree's to
/// make and a search of it somewhat more: it wins where bodies jump.
std::unique_ptr<BroadPhase> make_octree(const BroadPhase::Options& options = {});

/// Every pair of boxes. The reference. Cost: O(n^2), a query O(n).
std::unique_ptr<BroadPhase> make_brute_force(const BroadPhase::Options& options = {});

} // namespace oncollide
