#pragma once
#include <algorithm>
#include <cstdint>
#include <variant>

#include <Eigen/Core>

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
    bool by_hulls = false; ///< the hulls were apart along `across`, by the last result's bound
    struct Rest {
        std::uint8_t walks = 0;   ///< skip the test for this many more traversals
        std::uint8_t in_vain = 0; ///< consecutive tests without result; sets `walks`
    };
    Rest hulls{};             ///< when to test the outer hulls again
    Rest inner_spheres{};     ///< when to test the inner spheres again
    bool near = false;        ///< the last traversal did not separate them
    bool meets = false;       ///< the pair probably met at the last poses
    bool met = false;         ///< `triangles` met, or came within the cutoff
    TrianglePair triangles{}; ///< witness of contact; index 0 for a shape
    LeafPair leaves{};        ///< leaves of the sphere-trees that touched
    /// For a map the cell, replacing its triangle index; otherwise the position of the triangles in the trees.
    std::variant<std::monostate, MapCell, MeetingHint<ObbTree, ObbTree>, MeetingHint<TerrainTree, ObbTree>,
                 MeetingHint<ObbTree, TerrainTree>>
        place = std::monostate();

    void take_witness(const PairMemory& other) { met = other.met, triangles = other.triangles, place = other.place; }
    /// @param travel  current travel of both bodies
    double gap(double travel) const { return apart_until - travel - 0x1p-50 * travel; }
    /// They cannot have separated before moving by this distance.
    double depth(double travel) const { return meet_until - travel - 0x1p-50 * travel; }
    void meet(double depth, double travel) { meet_until = (travel + depth) * (1 - 0x1p-52); }
    void part(double gap, double travel) { apart_until = std::max(apart_until, (travel + gap) * (1 - 0x1p-52)); }
};

} // namespace oncollide
