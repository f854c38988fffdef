#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace oncollide {

/// "; did you mean 'octree'?" for the name that is nearest to `word` in spelling, or else the first that contains it;
/// nothing where none is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& names);

/// What follows the message that `word` is no valid name: "; did you mean 'octree'? valid: kd, octree, brute".
/// @param label  what stands before the names
std::string valid_names(std::string_view word, const std::vector<std::string_view>& names,
                        std::string_view label = "valid");

} // namespace oncollide
