#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/options.hpp"
#include "cli/standard_output.hpp"
#include "common/statistics.hpp"

#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

// Commands that measure share this text and these parsers.
namespace oncollide::tools {

/// Rejected and tested regions of delimitation, by level below the root: "0/2 81/112".
std::string regions_text(std::span<const DelimitationLevel> levels);

/// Parses "4-8", "6" or "2,5-7" to ascending numbers from 1 to 16; `option` names the option in errors.
std::vector<int> parse_depths(const std::string& option, const std::string& text);

/// Parses "2500,10k,1M" to ascending numbers from 1 to `most`; `option` names the option in errors.
std::vector<std::size_t> parse_counts(const char* option, const std::string& list, std::size_t most);

/// The parts of a comma-separated list, including empty ones.
std::vector<std::string> split(const std::string& list);

/// Lines that name the program, compiler, peer and machine of a result.
std::string describe_program(const std::string& backend);
/// The settings that affect a result, on one line; `accuracy` replaces the text of the accuracy.
std::string describe(const Settings& settings, const std::string& accuracy = {}, bool one_exact_level = true);

template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args)
{
    write_to_stdout(printable_lines(fmt::format(format, std::forward<Args>(args)...)));
}

} // namespace oncollide::tools
