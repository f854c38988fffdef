#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/obb/traversal.hpp>
#include <oncollide/narrowphase/spheres/walk.hpp>

namespace oncollide {

/// What is remembered of a pair from one frame to the next. A witness is a hint: it is tried first and counts only
/// where it holds again, so results do not depend on it. A gap is used up by what the bodies can have moved since it
/// was certified: until then they are apart.
struct PairMemory {
    double apart_until = 0; ///< while their travel is less, so far are the bodies apart at least
    double meet_until = 0;  ///< while their travel is less, their surfaces meet
    double walked_at = -1;  ///< their travel when they were walked last, or parted by their hulls
    Eigen::Vector3f across = Eigen::Vector3f::Zero(); ///< what parted their hulls (hull_gap), or nearly did
    struct Rest {
        std::uint8_t walks = 0;   ///< not looked at for so many more walks
        std::uint8_t in_vain = 0; ///< looked at so many times in a row, which is why
    };
    Rest hulls{};             ///< around them
    Rest balls{};             ///< within them
    bool near = false;        ///< their last walk did not part them
    bool met = false;         ///< `triangles` met, or were as near as was asked
    TrianglePair triangles{}; ///< witness of contact; 0 for a shape
    LeafPair leaves{};        ///< leaves of the sphere-trees that touched
    /// Of a map the cell, in place of its triangle; else where the triangles are.
    std::variant<std::monostate, MapCell, MeetingHint<ObbTree, ObbTree>, MeetingHint<TerrainTree, ObbTree>,
                 MeetingHint<ObbTree, TerrainTree>>
        place = std::monostate();

    /// @param travel  of both, now
    double gap(double travel) const { return apart_until - travel - 0x1p-50 * travel; }
    /// So far must they move before they can have parted.
    double depth(double travel) const { return meet_until - travel - 0x1p-50 * travel; }
    void meet(double depth, double travel) { meet_until = (travel + depth) * (1 - 0x1p-52); }
    void part(double gap, double travel) { apart_until = std::max(apart_until, (travel + gap) * (1 - 0x1p-52)); }
};

/// The memory of the candidate pairs. Each stays where it is for as long as its pair is a candidate.
class PairCache {
public:
    /// Keeps what is remembered of pairs that were candidates before, and forgets the others.
    /// @param pairs  sorted
    /// @param fresh  by slot: what is remembered of such a body is void; empty: of none
    void begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> fresh);
    /// Of pair number `i` of the frame.
    PairMemory& operator[](std::size_t i) { return memories_[now_[i].row]; }
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
