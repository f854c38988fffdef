#include "clash/parts/part_details.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include <oncollide/base/utf8.hpp>

namespace oncollide::tools {

PartDetails details_of(const std::string& extras, double scale)
{
    PartDetails details;
    if (extras.empty()) return details;
    const auto json = nlohmann::json::parse(as_utf8(extras), nullptr, false);
    if (!json.is_object()) return details;
    if (const auto at = json.find("deflection"); at != json.end() && at->is_number())
        if (const double deflection = scale * at->get<double>(); deflection > 0 && std::isfinite(deflection))
            details.deflection = deflection;
    const auto text = [&](const char* key) {
        const auto at = json.find(key);
        return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
    };
    details.part_class = text("class"), details.guid = text("guid"), details.type = text("type");
    details.storey = text("storey"), details.discipline = text("discipline");
    return details;
}

std::string class_text(const std::string& part_class)
{
    constexpr std::string_view prefix = "Ifc", suffix = "StandardCase";
    if (!part_class.starts_with(prefix)) return part_class;
    std::string text = part_class.substr(prefix.size());
    if (text.ends_with(suffix) && text != suffix) text.resize(text.size() - suffix.size());
    return text;
}

} // namespace oncollide::tools
