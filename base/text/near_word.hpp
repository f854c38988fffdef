#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace oncollide {

/// "; did you mean 'octree'?" for the name with the smallest edit distance to `word`, or else the first that contains
/// it; empty if no name is similar.
std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& names);

/// The end of an error message that rejects `word`: "; did you mean 'octree'? valid: kd, octree, brute".
/// @param label  stands before the names
std::string valid_names(std::string_view word, const std::vector<std::string_view>& names,
                        std::string_view label = "valid");

} // namespace oncollide
