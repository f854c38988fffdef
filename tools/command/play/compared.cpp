#include "play/compared.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

/// The properties that decide whether a body is compared with another.
struct Kind {
    bool is_static;
    std::uint32_t layer, mask, group;
    bool operator==(const Kind&) const = default;
};

bool compared(const Kind& a, const Kind& b)
{
    return !(a.is_static && b.is_static) && (a.layer & b.mask) && (b.layer & a.mask) &&
           (a.group == 0 || a.group != b.group);
}

} // namespace

std::string why_nothing_is_compared(const Scene& scene)
{
    if (scene.size() == 0) return "the scene has no bodies";
    if (scene.size() == 1) return "the scene has only one body";
    std::vector<Kind> kinds; // kinds of the bodies before; most scenes end with the second body
    for (std::size_t body = 0; body < scene.size(); ++body) {
        const Kind kind{scene.is_static[body] != 0, scene.layers[body], scene.masks[body], scene.groups[body]};
        if (std::ranges::any_of(kinds, [&](const Kind& other) { return compared(kind, other); })) return {};
        if (std::ranges::find(kinds, kind) == kinds.end()) kinds.push_back(kind);
    }
    if (std::ranges::all_of(kinds, &Kind::is_static)) return fmt::format("all {} bodies are static", scene.size());
    return fmt::format("groups and layers keep all {} bodies apart", scene.size());
}

} // namespace oncollide::tools
