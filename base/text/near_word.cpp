#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/near_word.hpp>

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace oncollide {
namespace {

constexpr std::size_t longest_word = 100; ///< longer than any valid name; limits the cost

/// Levenshtein distance.
std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t changed = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

/// Empty if no name is similar.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& names)
{
    if (word.empty() || word.size() > longest_word) return {};
    std::string_view best;
    std::size_t least = word.size() < 3 ? 2 : word.size() < 6 ? 3 : 4; // accept only fewer edits than this
    for (const std::string_view name : names) {
        // Names of files and bodies may be of any length: if the lengths alone differ too much, skip the name.
        const std::size_t longer = std::max(name.size(), word.size()) - std::min(name.size(), word.size());
        if (longer >= least) continue;
        if (const std::size_t distance = edit_distance(word, name); distance < least && distance < name.size())
            least = distance, best = name;
    }
    const std::string_view core = word.substr(std::min(word.find_first_not_of('-'), word.size()));
    if (!best.empty() || core.size() < 3) return best;
    const auto holds = [&](std::string_view name) { return name.find(core) != std::string_view::npos; };
    const auto found = std::find_if(names.begin(), names.end(), holds);
    return found == names.end() ? std::string_view() : *found;
}

} // namespace

std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& names)
{
    const std::string_view best = nearest(word, names);
    return best.empty() ? "" : fmt::format("; did you mean '{}'?", best);
}

std::string valid_names(std::string_view word, const std::vector<std::string_view>& names, std::string_view label)
{
    const std::string hint = did_you_mean(word, names);
    return fmt::format("{} {}: {}", hint.empty() ? ";" : hint, label, listed(names));
}

} // namespace oncollide
