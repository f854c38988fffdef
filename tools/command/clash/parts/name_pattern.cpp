#include "clash/parts/name_pattern.hpp"

namespace oncollide::tools {

bool matches(std::string_view pattern, std::string_view name)
{
    std::size_t p = 0, n = 0, star = pattern.npos, from = 0;
    const auto fits = [&] {
        if (p == pattern.size()) return false;
        if (pattern[p] == '?') return ++p, ++n, true;
        const bool plain = pattern[p] == '\\' && p + 1 < pattern.size();
        if (pattern[p + plain] != name[n]) return false;
        return p += 1 + plain, ++n, true;
    };
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*')
            star = ++p, from = n; // the star matches no text at first, and more if the rest does not match
        else if (!fits()) {
            if (star == pattern.npos) return false;
            p = star, n = ++from;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

} // namespace oncollide::tools
