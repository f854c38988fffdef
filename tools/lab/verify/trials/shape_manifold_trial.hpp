#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "verify/cases/drawn_shapes.hpp"
#include "verify/oracle/shape_truth.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {

/// Counts of manifolds of shapes, judged by closed forms and extended precision (oracle/shape_truth.hpp).
struct ShapeManifoldTally {
    struct Fault {
        std::uint64_t seed;
        oracle::ShapeClaim claim;
        std::string what;
    };
    struct Counts {
        std::uint64_t pairs = 0, meet = 0, near = 0;
        std::uint64_t regions = 0, points = 0;
        std::uint64_t faulty = 0;  ///< pairs with a fault
        std::vector<Fault> faults; ///< in the order of the seeds

        std::array<std::uint64_t, oracle::shape_claim_count> claims() const; ///< faults of each
        Counts& operator+=(const Counts& o);
    };
    std::map<std::pair<int, int>, Counts> by_kinds; ///< numbers of shape_kinds; from 8 on of ground_kinds

    Counts all() const;
    ShapeManifoldTally& operator+=(const ShapeManifoldTally& o);
};

/// "sphere box", for a key of by_kinds.
std::string name_of_kinds(const std::pair<int, int>& kinds);

/// Reads two names of shape_kinds and ground_kinds, in any order, separated by a comma. Throws Error{usage}, also for
/// two half-spaces and for a ground with a polytope.
std::pair<int, int> kinds_of(const std::string& names);

/// The pairs of `count` seeds from `first` on. Kinds take turns, or are those given; either way a seed is the same case
/// of its kinds. Does not depend on the number of threads.
ShapeManifoldTally try_shape_manifolds(std::uint64_t first, std::uint64_t count, int threads,
                                       const std::function<void()>& done, std::optional<std::pair<int, int>> only = {});

} // namespace oncollide::tools
