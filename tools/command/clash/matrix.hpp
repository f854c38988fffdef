#pragma once
#include <string>
#include <vector>

#include "clash/grouping.hpp"
#include "cli/lengths.hpp"

namespace oncollide::tools {

/// The clash matrix of a project: limits by discipline, class or storey of the parts.
class ClashMatrix {
public:
    /// Reads {"by": "discipline", "rules": [{"a": "MEP*", "b": "STR*", "clearance": "50mm", "tolerance": "2mm"},
    /// {"a": "ARC", "b": "ARC", "skip": true}]}. Lengths without a unit are in `unit`. Throws Error{bad_data}.
    ClashMatrix(const std::string& file, const Unit& unit);

    /// The limits of the first rule that fits the parts, in either order. `other` has the limits that this rule leaves
    /// out, and the limits of a pair without a rule.
    PairLimits limits(const Part& a, const Part& b, const PairLimits& other) const;
    /// No rule has a larger clearance or tolerance.
    double largest() const;
    /// For each rule that fits no two parts of the list: "rule 3 ('MEP*' and 'STR*')".
    std::vector<std::string> idle_rules(const PartList& list) const;

private:
    struct Rule {
        std::string a, b;
        double clearance = -1, tolerance = -1; ///< below 0: not given
        bool skip = false;
    };
    bool fits(const std::string& pattern, const Part& part) const;

    GroupKey by_;
    std::vector<Rule> rules_;
};

} // namespace oncollide::tools
