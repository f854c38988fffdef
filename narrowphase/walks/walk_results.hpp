#pragma once
#include <cstdint>
#include <optional>

#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/walks/swept_motion.hpp>

namespace oncollide {

/// Bounds on a distance.
template <class Pair>
struct DistanceBounds {
    double lower, upper;         ///< both 0 if the geometries were found to meet
    std::optional<Pair> nearest; ///< two primitives at the distance `upper`, or that meet
};

/// How a distance compares with a cutoff.
template <class Pair>
struct Comparison {
    int sign; ///< -1: the distance is at most the cutoff; 1: it is more; 0: it differs from the cutoff by no more than
              ///< rounding
    double bound; ///< sign 1: a lower bound of the distance, above the cutoff; else an upper bound, for sign 0 at least
                  ///< the cutoff
    std::optional<Pair> witness; ///< sign -1: two primitives at most the cutoff apart
};

template <class Pair>
struct NearBounds {
    bool near;
    double bound; ///< near: upper bound of the distance, clearance + tolerance (or + rounding, if that is more); else
                  ///< lower bound, at least the clearance; > 0 unless doubles cannot express it
    std::optional<Pair> witness; ///< near: two primitives within `bound`
};

/// When two primitives first meet; see swept_motion.hpp.
template <class Pair>
struct FirstEntry : PartsEntry {
    std::optional<Pair> pair; ///< the first to meet, if any may meet in the window
};

/// Two boxes around the primitives that met last, some levels above them: box `lane` of a node on each side.
template <BoxHierarchy A, BoxHierarchy B>
struct MeetingHint {
    typename A::Node a;
    typename B::Node b;
    std::uint8_t lane_a, lane_b;
    std::uint32_t of_a, of_b; ///< identity() of the hierarchies, if they store nodes

    MeetingHint(const A& in_a, const typename A::Node& at_a, std::uint8_t k_a, const B& in_b,
                const typename B::Node& at_b, std::uint8_t k_b)
        : a(at_a), b(at_b), lane_a(k_a), lane_b(k_b), of_a(identity(in_a)), of_b(identity(in_b))
    {
    }
    bool holds_in(const A& in_a, const B& in_b) const { return of_a == identity(in_a) && of_b == identity(in_b); }

private:
    static std::uint32_t identity(const auto& hierarchy)
    {
        if constexpr (requires { hierarchy.identity(); })
            return hierarchy.identity();
        else
            return 0;
    }
};

} // namespace oncollide
