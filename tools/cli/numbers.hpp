#pragma once
#include <string>
#include <vector>

namespace oncollide::tools {

/// The numbers of an option's text, with spaces or commas between them. Throws Error{usage} unless there are `count`,
/// all finite; the message shows `form`, e.g. "x y z".
std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count,
                                  const char* form);
/// The error that parse_numbers throws, for what a caller finds wrong with the numbers.
[[noreturn]] void refuse_numbers(const std::string& option, const std::string& text, const std::string& why,
                                 const char* form);

} // namespace oncollide::tools
