#include <oncollide/scenes/files/assembly/node_paths.hpp>

#include <fmt/format.h>

#include <oncollide/scenes/files/assembly/raw_assembly.hpp>

namespace oncollide {

namespace {

bool is_inside_character(char c)
{
    return (static_cast<unsigned char>(c) & 0xc0) == 0x80; // true within a character of UTF-8
}

/// Cuts between characters.
std::string ends_of(std::string_view name)
{
    constexpr std::string_view gap = "...";
    constexpr std::size_t part = (NodePaths::most_name - gap.size()) / 2;
    std::size_t head = part, tail = name.size() - part;
    while (head > 0 && is_inside_character(name[head])) --head;
    while (tail < name.size() && is_inside_character(name[tail])) ++tail;
    return fmt::format("{}{}{}", name.substr(0, head), gap, name.substr(tail));
}

} // namespace

std::string NodePaths::name(std::uint32_t node) const
{
    const std::string_view name = name_of_(node);
    if (name.empty()) return fmt::format("node {}", node);
    return name.size() <= most_name ? std::string(name) : ends_of(name);
}

std::string NodePaths::path(std::uint32_t node) const
{
    std::string path = name(node);
    std::uint32_t next = above_[node];
    for (int level = 1; next != no_node && level < levels_; ++level, next = above_[next]) {
        const std::string above = name(next);
        if (above.size() + 1 + path.size() > most_path) break;
        path.insert(0, above + "/");
    }
    return path;
}

} // namespace oncollide
