#include <oncollide/robots/files/mjcf/mjcf_pairs.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide {

MjcfPairs::MjcfPairs(const MjcfDocument& document) : document_(document)
{
    const RobotSource& source = document.source();
    document.each("option", [&](const XmlElement& flag) {
        if (flag.name == "flag" && !flag.attribute("filterparent").empty())
            filters_parents_ = flag.attribute("filterparent") != "disable";
    });
    document.each("contact", [&](const XmlElement& element) {
        const bool is_pair = element.name == "pair";
        if (!is_pair && element.name != "exclude") source.fail_at(element, "is unknown in a contact section");
        const auto names = std::minmax(source.required(element, is_pair ? "geom1" : "body1"),
                                       source.required(element, is_pair ? "geom2" : "body2"));
        (is_pair ? pairs_ : excludes_).insert(names);
        if (is_pair) geoms_.insert({names.first, names.second});
    });
}

bool MjcfPairs::is_tested(const MjcfTree& tree, const MjcfTree::GeomLink& a, const MjcfTree::GeomLink& b) const
{
    if (!a.geom.empty() && !b.geom.empty() && pairs_.contains(std::minmax(a.geom, b.geom))) return true;
    const MjcfTree::Body &of_a = tree.bodies[a.body], &of_b = tree.bodies[b.body];
    if (of_a.weld == of_b.weld) return false;
    if (!excludes_.empty() && excludes_.contains(std::minmax(of_a.name, of_b.name))) return false;
    const auto above = [&](std::uint32_t weld) { return tree.bodies[tree.bodies[weld].parent].weld; };
    if (filters_parents_ && of_a.weld && of_b.weld && (of_a.weld == above(of_b.weld) || of_b.weld == above(of_a.weld)))
        return false;
    return (a.contype & b.conaffinity) || (b.contype & a.conaffinity);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> MjcfPairs::excluded(const MjcfTree& tree) const
{
    document_.each("contact", [&](const XmlElement& element) {
        for (const char* key : {"body1", "body2"}) {
            const std::string& name = element.attribute(key);
            if (element.name != "exclude" || std::ranges::count(tree.bodies, name, &MjcfTree::Body::name)) continue;
            std::vector<std::string_view> names;
            for (const MjcfTree::Body& body : tree.bodies) names.push_back(body.name);
            document_.source().fail_at(element, fmt::format("there is no body {}{}", oncollide::quoted(name),
                                                            printable(did_you_mean(name, names))));
        }
        for (const char* key : {"geom1", "geom2"}) {
            const std::string& name = element.attribute(key);
            const auto is_it = [&](const auto& link) { return link && link->geom == name; };
            if (element.name == "pair" && !std::ranges::any_of(tree.links, is_it))
                document_.source().fail_at(element, fmt::format("there is no geom {}", oncollide::quoted(name)));
        }
    });
    std::vector<std::uint32_t> links; // with geoms
    for (std::uint32_t i = 0; i < tree.links.size(); ++i)
        if (tree.links[i]) links.push_back(i);
    constexpr std::size_t most_links = 20'000;
    if (links.size() > most_links)
        document_.source().fail_at(document_.root(), fmt::format("has more than {} links with geoms", most_links));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> excluded;
    for (std::size_t i = 0; i < links.size(); ++i)
        for (std::size_t k = i + 1; k < links.size(); ++k)
            if (!is_tested(tree, *tree.links[links[i]], *tree.links[links[k]]))
                excluded.emplace_back(links[i], links[k]);
    return excluded;
}

} // namespace oncollide
