#pragma once
#include <map>
#include <string>
#include <vector>

#include <oncollide/scenes/files/scene_file.hpp>

#include "clash/parts/part_list.hpp"

namespace oncollide::tools {

/// Applies the rules to parts, one by one. Keeps references.
class PartSelection {
public:
    PartSelection(PartList& list, const PartRules& rules) : list_(list), rules_(rules) {}

    /// Sets the group and the sets of a part, whose file and path are set.
    void choose(const AssemblyPart& from, Part& part);
    /// Throws Error{usage} for a pattern of a set that matched no part, and if the rules leave no pair of parts to
    /// compare. A group that matched no part is a warning, or such an error if the rules are strict.
    void finish();

private:
    bool matches_part(const std::string& pattern, const AssemblyPart& from, const Part& part);
    std::uint32_t group_of(const AssemblyPart& from, const Part& part);
    void check_pairs() const;
    std::uint32_t numbered(const std::string& key, const std::string& name);

    PartList& list_;
    const PartRules& rules_;
    std::map<std::string, std::uint32_t> numbers_;
    std::map<std::string, bool> used_; ///< by rule: it matched a part
};

} // namespace oncollide::tools
