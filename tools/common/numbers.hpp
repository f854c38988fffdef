#pragma once
#include <string>
#include <vector>

namespace oncollide::tools {

/// The numbers in an option's text, separated by spaces or commas. Throws Error{usage} unless there are `count`,
/// all finite; the message shows `form`, e.g. "x y z".
std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count,
                                  const char* form);
/// Throws the error of parse_numbers, for numbers that the caller finds invalid.
[[noreturn]] void refuse_numbers(const std::string& option, const std::string& text, const std::string& why,
                                 const char* form);

} // namespace oncollide::tools
