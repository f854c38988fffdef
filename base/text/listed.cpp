#include <oncollide/base/text/listed.hpp>

#include <fmt/format.h>

namespace oncollide {

std::string shortened(std::string_view text, std::size_t most)
{
    constexpr std::string_view gap = "...";
    if (text.size() <= most) return std::string(text);
    const auto inside = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80; };
    std::size_t head = most / 2, tail = text.size() - (most - most / 2 - gap.size());
    while (head > 0 && inside(head)) --head; // do not cut a character of UTF-8
    while (tail < text.size() && inside(tail)) ++tail;
    return fmt::format("{}{}{}", text.substr(0, head), gap, text.substr(tail));
}

std::string listed(const std::vector<std::string_view>& names)
{
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (text.size() > most_of_a_list) return text + fmt::format(", and {} more", names.size() - i);
        text += (i ? ", " : "") + shortened(names[i]);
    }
    return text;
}

std::string listed(const std::vector<std::string>& names)
{
    return listed(std::vector<std::string_view>(names.begin(), names.end()));
}

} // namespace oncollide
