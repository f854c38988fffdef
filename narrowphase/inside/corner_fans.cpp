#include <oncollide/narrowphase/inside/corner_fans.hpp>

#include <map>
#include <utility>

namespace oncollide {

std::vector<FanCorner> fans_of(const Mesh& mesh, std::span<const std::uint8_t> flags)
{
    std::vector<FanCorner> corners;
    for (std::uint32_t t = 0; t < flags.size(); ++t)
        for (std::uint8_t i = 0; i < 3; ++i)
            if (flags[t] >> i & 1) corners.push_back({t, i, std::uint32_t(corners.size())});
    // `fan` links to another corner of the same fan; one corner of each fan links to itself.
    const auto root_of = [&](std::uint32_t k) {
        while (corners[k].fan != k) k = corners[k].fan = corners[corners[k].fan].fan;
        return k;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> at_edge; // edges that leave the common corner
    for (std::uint32_t k = 0; k < corners.size(); ++k) {
        const Triangle& t = mesh.triangles[corners[k].triangle];
        const std::size_t i = corners[k].corner;
        for (const std::uint32_t end : {t[(i + 1) % 3], t[(i + 2) % 3]})
            if (const auto [other, first] = at_edge.try_emplace({t[i], end}, k); !first)
                corners[root_of(k)].fan = root_of(other->second);
    }
    for (std::uint32_t k = 0; k < corners.size(); ++k) corners[k].fan = root_of(k);
    return corners;
}

} // namespace oncollide
