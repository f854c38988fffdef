#pragma once
#include <cstdint>
#include <string>
#include <utility>

namespace oncollide::tools {

/// The results of one family of hard cases. Sums with +=.
struct Tally {
    std::string family;
    std::uint64_t cases = 0;           ///< pairs of triangles, or of bodies at one pose
    std::uint64_t results = 0;         ///< of oncollide; each must be correct
    std::uint64_t missed = 0;          ///< results that miss a collision, or bodies within the clearance
    std::uint64_t wrong = 0;           ///< exact results with a false collision or the wrong kind of contact
    std::uint64_t false_positives = 0; ///< `within` for bodies that do not collide: allowed
    std::uint64_t bounds = 0;          ///< certified bounds compared with the true distance
    std::uint64_t broken = 0;          ///< wrong bounds
    std::uint64_t changed = 0;         ///< results that changed, but must not
    std::string first_fault{};         ///< description of the first fault

    std::uint64_t faults() const { return missed + wrong + broken + changed; }
    /// Counts one fault of a kind, e.g. fault(&Tally::missed, "...").
    void fault(std::uint64_t Tally::*kind, const std::string& what)
    {
        ++(this->*kind);
        if (first_fault.empty()) first_fault = what;
    }
    Tally& operator+=(const Tally& o);
};

/// A count of a tally, by its title in tables and its name in files.
struct TallyCount {
    const char *title, *name;
    int width; ///< in tables
    std::uint64_t Tally::*of;
};
constexpr TallyCount tally_counts[] = {{"cases", "cases", 9, &Tally::cases},
                                       {"results", "answers", 11, &Tally::results},
                                       {"missed", "missed", 8, &Tally::missed},
                                       {"wrong", "wrong", 7, &Tally::wrong},
                                       {"false +", "false_positives", 9, &Tally::false_positives},
                                       {"bounds", "bounds", 9, &Tally::bounds},
                                       {"broken", "bounds_broken", 8, &Tally::broken},
                                       {"changed", "changed", 9, &Tally::changed}};

inline Tally& Tally::operator+=(const Tally& o)
{
    for (const TallyCount& count : tally_counts) this->*count.of += o.*count.of;
    if (first_fault.empty()) first_fault = o.first_fault;
    return *this;
}

} // namespace oncollide::tools
