#pragma once
#include <span>
#include <string>
#include <vector>

#include "clash/clashes.hpp"

namespace oncollide::tools {

/// The property of the parts by which clashes are grouped.
enum class GroupKey : std::uint8_t { part_class, storey, discipline, part };

/// Parses "class,storey"; empty text: no keys. Throws Error{usage}.
std::vector<GroupKey> group_keys_from(const std::string& text);
std::string_view name_of(GroupKey key);

/// The property of a part, such as "Wall" or "Level 1"; "without storey" if it is unknown.
std::string text_of(GroupKey key, const Part& part);
/// The property of both parts: "Beam and Wall"; "Wall" if they agree. The part of set A comes first, if there are sets.
std::string text_of(GroupKey key, const PartList& list, const Clash& clash);

struct ClashGroup {
    std::string name;
    std::vector<std::size_t> rows; ///< in the order of the clashes
};

/// Groups the clashes `rows` by the keys, one after the other. `part` makes few groups: the part with the most clashes
/// and all of them, then the same for the rest. Groups are in the order of their first rows; without keys there is one
/// group without a name.
std::vector<ClashGroup> groups_of(const PartList& list, const std::vector<Clash>& clashes,
                                  std::span<const std::size_t> rows, const std::vector<GroupKey>& keys);

} // namespace oncollide::tools
