#include "common/text.hpp"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>

#include "cli/build_info.hpp"
#include "cli/system.hpp"
#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {
double median(std::vector<double> values)
{
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double mean(const std::vector<double>& values)
{
    return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

std::string regions_text(std::span<const DelimitationLevel> levels)
{
    std::string text;
    for (const DelimitationLevel& level : levels.subspan(std::min<std::size_t>(1, levels.size())))
        text += fmt::format("{}{}/{}", text.empty() ? "" : " ", level.regions_rejected, level.regions);
    return text;
}

std::vector<int> parse_depths(const std::string& option, const std::string& text)
{
    constexpr int deepest = 16;
    std::vector<int> depths;
    const auto fail = [&] {
        throw Error(ErrorKind::usage,
                    fmt::format("{} {}: expected depths from 1 to {}, such as 6, 4-8 or 2,5-7", option, text, deepest));
    };
    const char *at = text.data(), *const end = at + text.size();
    const auto number = [&] {
        int value = 0;
        const auto [rest, error] = std::from_chars(at, end, value);
        if (error != std::errc{} || value < 1 || value > deepest) fail();
        at = rest;
        return value;
    };
    while (true) {
        const int first = number();
        int last = first;
        if (at != end && *at == '-') ++at, last = number();
        for (int depth = first; depth <= last; ++depth) depths.push_back(depth);
        if (at == end) break;
        if (*at++ != ',') fail();
    }
    std::sort(depths.begin(), depths.end());
    depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
    if (depths.empty()) fail();
    return depths;
}

std::string describe(const Settings& s, const std::string& stand_in, bool one_exact_level)
{
    const ExactLevel exact = exact_level(s);
    const bool bounded = s.max_error || s.depth || exact == ExactLevel::off;
    const std::string accuracy = !stand_in.empty() ? stand_in
                                 : s.max_error     ? fmt::format("max error {} m", *s.max_error)
                                 : s.depth         ? fmt::format("depth {}", *s.depth)
                                 : bounded ? fmt::format("max error {} % of the smaller body", 100 * default_error)
                                           : std::string();
    std::string text =
        fmt::format("{}{}{}mode {}, broad {}, threads {}, age {}", accuracy, accuracy.empty() ? "" : ", ",
                    one_exact_level ? fmt::format("exact {}, ", name_of(exact)) : "", name_of(s.mode),
                    name_of(s.broad_phase), thread_count(s), s.age_limit);
    if (s.clearance > 0) text += fmt::format(", clearance {} m", s.clearance);
    if (s.bounding_volume != BoundingVolume::automatic)
        text += fmt::format(", bounding volume {}", name_of(s.bounding_volume));
    if (!s.coherence) text += ", no coherence";
    if (s.node_budget) text += fmt::format(", node budget {}", s.node_budget);
    if (s.memory_budget) text += fmt::format(", memory budget {}", s.memory_budget);
    if (!s.skip.empty()) text += fmt::format(", without {}", fmt::join(names_of(s.skip), ", "));
    return text;
}

std::string describe_program(const std::string& backend)
{
    return fmt::format("program    oncollide {}, {}; {}, flags '{}'; {}, one thread\n"
                       "machine    {}, {} hardware threads\n",
                       version, backend, build_text(), build_flags(), fcl_text(), processor_name(), hardware_threads());
}

std::vector<std::string> split(const std::string& list)
{
    std::vector<std::string> parts;
    for (std::size_t at = 0; at <= list.size();) {
        const std::size_t comma = std::min(list.find(',', at), list.size());
        parts.push_back(list.substr(at, comma - at));
        at = comma + 1;
    }
    return parts;
}

namespace {

/// Parses "2500", "10k" or "1M", from 1 to `most`.
std::size_t parse_count(const char* option, const std::string& text, std::size_t most)
{
    std::size_t value = 0, unit = 1;
    const char* const end = text.data() + text.size();
    auto [rest, error] = std::from_chars(text.data(), end, value);
    if (rest != end && (*rest == 'k' || *rest == 'M')) unit = *rest++ == 'k' ? 1'000 : 1'000'000;
    if (error != std::errc{} || rest != end || value < 1 || value > most / unit)
        usage(fmt::format("{} {}: expected numbers from 1 to {}, such as {}", option, text, most,
                          most > 10'000 ? "2500,10k,1M" : "1,2"));
    return value * unit;
}

} // namespace

std::vector<std::size_t> parse_counts(const char* option, const std::string& list, std::size_t most)
{
    std::vector<std::size_t> counts;
    for (const std::string& part : split(list)) counts.push_back(parse_count(option, part, most));
    std::sort(counts.begin(), counts.end());
    counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
    return counts;
}

} // namespace oncollide::tools
