#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/spheres/walk.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

namespace oncollide {

/// Data kept of a pair between frames. Witnesses are hints: they are tested first and count only if they hold again, so
/// results do not depend on them. A gap shrinks by the bodies' motion since it was certified; while it is positive, the
/// bodies are apart.
struct PairMemory {
    double apart_until = 0;                           ///< a lower bound of the distance is this minus the travel
    double meet_until = 0;                            ///< their surfaces meet while the travel is less than this
    double walked_at = -1;                            ///< travel at the last traversal or separation by hulls
    Eigen::Vector3f across = Eigen::Vector3f::Zero(); ///< separating direction of their hulls (hull_gap), or the last
                                                      ///< one tried
    struct Rest {
        std::uint8_t walks = 0;   ///< skip the test for this many more traversals
        std::uint8_t in_vain = 0; ///< consecutive tests without result; sets `walks`
    };
    Rest hulls{};             ///< of the outer hulls
    Rest balls{};             ///< of the inner spheres
    bool near = false;        ///< the last traversal did not separate them
    bool met = false;         ///< `triangles` met, or came within the cutoff
    TrianglePair triangles{}; ///< witness of contact; index 0 for a shape
    LeafPair leaves{};        ///< leaves of the sphere-trees that touched
    /// For a map the cell, replacing its triangle index; otherwise the position of the triangles in the trees.
    std::variant<std::monostate, MapCell, MeetingHint<ObbTree, ObbTree>, MeetingHint<TerrainTree, ObbTree>,
                 MeetingHint<ObbTree, TerrainTree>>
        place = std::monostate();

    /// @param travel  current travel of both bodies
    double gap(double travel) const { return apart_until - travel - 0x1p-50 * travel; }
    /// They cannot have separated before moving by this distance.
    double depth(double travel) const { return meet_until - travel - 0x1p-50 * travel; }
    void meet(double depth, double travel) { meet_until = (travel + depth) * (1 - 0x1p-52); }
    void part(double gap, double travel) { apart_until = std::max(apart_until, (travel + gap) * (1 - 0x1p-52)); }
};

/// The memory of the candidate pairs. An element keeps its address within a frame, and its row while its pair is a
/// candidate.
class PairCache {
public:
    /// Keeps the memory of pairs that were candidates in the last frame, and drops all other memory.
    /// @param pairs  sorted
    /// @param fresh  by slot: true if the memory of the body's pairs is void; empty: false for all
    void begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> fresh);
    /// The memory of pair `i` of the frame.
    PairMemory& operator[](std::size_t i)
    {
        ONCOLLIDE_ASSERT(i < now_.size());
        return memories_[now_[i].row];
    }
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(pairs).
    std::string validate() const;
    std::size_t bytes() const
    {
        return memories_.capacity() * sizeof(PairMemory) + (now_.capacity() + before_.capacity()) * sizeof(Known) +
               free_.capacity() * sizeof(std::uint32_t);
    }

private:
    struct Known {
        BodyPair pair;
        std::uint32_t row; ///< in memories_
    };
    std::uint32_t make_row();

    std::vector<PairMemory> memories_;
    std::vector<std::uint32_t> free_; ///< rows
    std::vector<Known> now_, before_; ///< by pair
};

} // namespace oncollide
