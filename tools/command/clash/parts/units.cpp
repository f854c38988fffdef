#include "clash/parts/units.hpp"

#include <filesystem>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "clash/parts/name_pattern.hpp"
#include "cli/arguments.hpp"
#include "convert/converters.hpp"

namespace oncollide::tools {
Units::Units(const std::vector<std::string>& texts) : reported_(&unit_from("--units", "mm"))
{
    for (const std::string& text : texts) {
        const std::size_t at = text.rfind('=');
        if (at == text.npos)
            reported_ = &unit_from("--units", text);
        else if (at == 0)
            usage(fmt::format("--units {}: expected a unit, or PATTERN=UNIT such as 'frame*.stl=m'", text));
        else
            of_files_.push_back({text.substr(0, at), &unit_from("--units " + text + ":", text.substr(at + 1))});
    }
}

double Units::scale_of(const std::string& file) const
{
    const std::filesystem::path path(file);
    const std::string extension = lower_extension(path);
    // These are read in metres.
    const bool says_itself = extension == ".dae" || extension == ".3mf" || converter_of(path);
    const Unit* unit = is_assembly_file(path) ? &unit_from("", "m") : reported_;
    for (const OfFiles& some : of_files_) {
        if (!matches(some.pattern, file) && !matches(some.pattern, path.filename().string())) continue;
        if (says_itself)
            usage(fmt::format("--units {}={}: {} defines its own unit", some.pattern, some.unit->name, file));
        unit = some.unit;
    }
    return unit == reported_ ? 1 : unit->millimetres / reported_->millimetres;
}

} // namespace oncollide::tools
