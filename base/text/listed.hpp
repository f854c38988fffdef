#pragma once
#include <string>
#include <string_view>
#include <vector>

// Names in messages: a file may hold any number of names of any length.
namespace oncollide {

constexpr std::size_t most_of_a_name = 100, most_of_a_list = 1500, most_of_a_message = 4000; ///< bytes

/// `text`, or its begin and end with "..." between them if it is longer than `most` bytes.
std::string shortened(std::string_view text, std::size_t most = most_of_a_name);

/// "kd, octree, brute": each name shortened, and "..., and 480 more" where the list becomes too long.
std::string listed(const std::vector<std::string_view>& names);
std::string listed(const std::vector<std::string>& names);

} // namespace oncollide
