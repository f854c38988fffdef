#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// What a DynamicTree reads of the bodies, columns of the caller's, by body.
struct BodyColumns {
    std::span<const Aabb> boxes;                      ///< world, metres, closed
    std::span<const std::uint32_t> layers{}, masks{}; ///< as in BodyFilter; both empty: every two bodies may collide
};

/// A box that was asked about overlaps a body.
struct BoxHit {
    std::uint32_t query, body; ///< number of the box in the question; the body
    friend bool operator==(BoxHit, BoxHit) = default;
    friend auto operator<=>(BoxHit, BoxHit) = default;
};

/// Bodies that come, go, move and rest, and which of their boxes overlap, kept from frame to frame: a frame costs what
/// changed in it, not what exists.
///
///     DynamicTree tree({.threads = 2});
///     tree.add(bodies);                                    // any number of changes, in bulk
///     tree.move(moved);
///     for (BodyPair pair : tree.find_pairs({boxes})) ...   // all pairs there are now
///
/// Bodies are rows of the caller's columns. One that is asleep forms pairs with bodies that are awake only; a static
/// body is one that is never woken. Whoever changes a body's box, layer or mask says so by move(); a moved body stays
/// asleep or awake. Not thread-safe.
/// Cost of find_pairs(): O(changed + pairs), about a microsecond a body that changed; where over a quarter changed, and
/// now and then when the tree has degraded out, O(n). Memory: 45 bytes a body and 8 a pair.
class DynamicTree {
public:
    struct Options {
        double margin = 0; ///< metres, >= 0: boxes are grown by so much in all before they are compared
        /// Metres, >= 0: the tree holds boxes larger by so much, and a body that stays inside its larger box costs only
        /// a comparison for each pair it is in. Never changes the answer.
        double fat = 0;
        int threads = 1; ///< never changes the answer
    };
    /// Throws Error{usage} for options out of range.
    DynamicTree();
    explicit DynamicTree(const Options& options);
    ~DynamicTree();
    DynamicTree(DynamicTree&&) noexcept;
    DynamicTree& operator=(DynamicTree&&) noexcept;

    // Each body at most once a call. All throw Error{usage} naming the body, and then have done nothing: add() if it is
    // there already, the others if it is not.
    void add(std::span<const std::uint32_t> bodies, bool asleep = false);
    void remove(std::span<const std::uint32_t> bodies);
    void move(std::span<const std::uint32_t> bodies);
    void sleep(std::span<const std::uint32_t> bodies);
    void wake(std::span<const std::uint32_t> bodies);

    /// Pairs of bodies whose boxes overlap now, not both asleep, that layers and masks allow; sorted, each once. Valid
    /// until the next change. Throws Error{bad_data} naming a body whose box is not finite or beyond 1e30 m,
    /// Error{usage} for columns that are too short.
    std::span<const BodyPair> find_pairs(const BodyColumns& columns);
    /// The first half of find_pairs(), which does it if need be: takes in the changes and finds the regions in which
    /// something may collide (progressive delimitation).
    void delimit(const BodyColumns& columns);
    /// What delimit() did, level by level, counted when asked for. Empty where so much had changed that all was
    /// searched, and after the next question or change taken in.
    std::span<const DelimitationLevel> levels();
    /// Bodies that it left: all, or those of the regions that the changed bodies reach. Every pair that a changed body
    /// is in is among them.
    std::uint64_t bodies_left();
    void survivors(std::vector<std::uint32_t>& bodies); ///< overwrites `bodies` with them, ascending

    /// Bodies whose boxes, grown by `margin` in all, overlap each of `boxes`, whatever their layers and sleep; sorted.
    /// Cost: about a microsecond a box. Takes in changes like find_pairs(), which will still report their pairs.
    void query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<BoxHit>& hits);

    std::size_t size() const; ///< bodies
    bool contains(std::uint32_t body) const;
    std::size_t bytes() const; ///< held from frame to frame

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
