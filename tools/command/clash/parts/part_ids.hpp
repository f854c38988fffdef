#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "clash/parts/part_list.hpp"

namespace oncollide::tools {

/// Adds a hash of geometry and pose to ids that several parts have, and a number if these are equal, too.
void make_ids_unique(PartList& list);

/// 64 bits of a text, the same on every machine.
std::uint64_t hash_of(std::string_view text);

/// The id of a clash, from the ids of its parts in either order: "c" and 16 hexadecimal digits, so that
/// spreadsheets keep it as text.
std::string clash_id(const Part& a, const Part& b);

} // namespace oncollide::tools
