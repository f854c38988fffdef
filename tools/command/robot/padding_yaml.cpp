// Clearances and allowed contacts, by yaml-cpp.
#include "robot/robot_padding.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "cli/lengths.hpp"
#include "robot/yaml_file.hpp"
#include <oncollide/base/text/near_word.hpp>

namespace oncollide::tools {

namespace {

class PaddingReader {
public:
    PaddingReader(const YamlFile& file, const PaddingNames& names) : file_(file), names_(names) {}

    PaddingRules read()
    {
        check_keys(file_.root(), {"environment", "self", "links", "bodies", "pairs", "allowed"});
        const YAML::Node root = file_.root(), links = root["links"], bodies = root["bodies"];
        if (const YAML::Node node = root["environment"]) rules_.padding.environment = clearance(node);
        if (const YAML::Node node = root["self"]) rules_.padding.self = clearance(node);
        each(links, "links", [&](const YAML::Node& name, double clear) {
            rules_.padding.links.push_back({link(name), clear});
        });
        each(bodies, "bodies", [&](const YAML::Node& name, double clear) {
            rules_.padding.bodies.push_back({body(name), clear});
        });
        if (const YAML::Node pairs = root["pairs"])
            for (const YAML::Node& pair : file_.list(pairs, "pairs")) read_pair(pair);
        if (const YAML::Node allowed = root["allowed"])
            for (const YAML::Node& pair : file_.list(allowed, "allowed")) {
                const auto [first, other] = sides(pair);
                if (const auto* const second = std::get_if<std::uint32_t>(&other))
                    rules_.allowed.push_back({.link = first, .other = *second});
                else
                    rules_.allowed.push_back({.link = first, .body = std::get<BodyId>(other)});
            }
        return std::move(rules_);
    }

private:
    void check_keys(const YAML::Node& node, const std::vector<std::string_view>& known) const
    {
        if (!node.IsMap()) file_.fail(node, "must be a map" + valid_names("", known, "its keys"));
        for (const auto& entry : node) {
            const std::string key = file_.text(entry.first, "a key");
            if (!std::ranges::count(known, key))
                file_.fail(entry.first, fmt::format("unknown key '{}'{}", printable(key), valid_names(key, known)));
        }
    }
    /// Metres, or a length with a unit.
    double clearance(const YAML::Node& node) const
    {
        double metres = -1;
        try {
            metres = length_from("a clearance", file_.text(node, "a clearance"), unit_from("", "m"));
        } catch (const Error& error) {
            if (error.kind() != ErrorKind::usage) throw;
            file_.fail(node, error.what());
        }
        if (!(metres <= 1e6)) file_.fail(node, fmt::format("a clearance of {} m; must be at most 1e6 m", metres));
        return metres;
    }
    template <class Take>
    void each(const YAML::Node& map, const char* what, Take take) const
    {
        if (!map) return;
        if (!map.IsMap()) file_.fail(map, fmt::format("{} must be a map of clearances by names", what));
        for (const auto& entry : map) take(entry.first, clearance(entry.second));
    }
    std::uint32_t link(const YAML::Node& node) const
    {
        const std::string name = file_.text(node, "a link's name");
        const auto found = names_.link(name);
        if (!found) file_.fail(node, names_.no_link(name));
        return *found;
    }
    BodyId body(const YAML::Node& node) const
    {
        const std::string name = file_.text(node, "a body's name");
        const auto found = names_.body(name);
        if (!found) file_.fail(node, fmt::format("the environment has no body '{}'", printable(name)));
        return *found;
    }
    /// A link, and a body or another link.
    std::pair<std::uint32_t, std::variant<std::uint32_t, BodyId>> sides(const YAML::Node& pair) const
    {
        if (!pair.IsSequence() || pair.size() != 2)
            file_.fail(pair, "must be a list of two names: a link, and a link or a body");
        const std::uint32_t first = link(pair[0]);
        const std::string other = file_.text(pair[1], "a name");
        if (const auto found = names_.body(other)) return {first, *found};
        if (const auto found = names_.link(other)) return {first, *found};
        file_.fail(pair[1], names_.no_link_or_body(other));
    }
    void read_pair(const YAML::Node& node)
    {
        check_keys(node, {"names", "clearance"});
        for (const char* key : {"names", "clearance"})
            if (!node[key]) file_.fail(node, fmt::format("has no {}", key));
        const auto [first, other] = sides(node["names"]);
        const double clear = clearance(node["clearance"]);
        if (const auto* const second = std::get_if<std::uint32_t>(&other))
            rules_.padding.pairs.push_back({first, *second, clear});
        else
            rules_.padding.bodies.push_back({std::get<BodyId>(other), clear, first});
    }

    const YamlFile& file_;
    const PaddingNames& names_;
    PaddingRules rules_;
};

} // namespace

PaddingRules read_padding_file(const std::string& path, const PaddingNames& names)
{
    PaddingRules rules;
    YamlFile::read(path, [&](const YamlFile& file) { rules = PaddingReader(file, names).read(); });
    return rules;
}

} // namespace oncollide::tools
