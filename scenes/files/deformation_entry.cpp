#include <oncollide/scenes/files/deformation_entry.hpp>

#include <fmt/format.h>

#include <oncollide/base/files/paths.hpp>
#include <oncollide/scenes/files/json/at_node.hpp>
#include <oncollide/scenes/files/tables/frame_source.hpp>
#include <oncollide/scenes/flutter.hpp>

namespace oncollide {

namespace {

std::shared_ptr<Deformation> read_flutter(const Node& node)
{
    node.only({"edge", "along", "normal", "growth", "waves"});
    auto flutter = std::make_shared<Flutter>();
    flutter->edge = node["edge"].vector3();
    flutter->along = node["along"].vector3(), flutter->normal = node["normal"].vector3();
    flutter->growth = node["growth"].number();
    constexpr std::size_t most_waves = 32;
    if (node["waves"].size() > most_waves) node["waves"].fail(fmt::format("at most {} waves are allowed", most_waves));
    for (const Node& row : node["waves"]) {
        double n[5];
        row.numbers(5, n);
        flutter->waves.push_back({n[0], n[1], n[2], n[3], n[4]});
    }
    at(node, [&] { flutter->check(); });
    return flutter;
}

} // namespace

std::shared_ptr<Deformation> read_deformation(const Node& entry, const std::filesystem::path& folder)
{
    if (!entry.is_object() || !entry.has("file")) {
        auto flutter = read_flutter(entry[entry.one_of({"file", "flutter"})]);
        flutter->recipe = Json::parse(entry.source()).dump();
        return flutter;
    }
    entry.only({"file", "path"});
    const FrameFile file = frame_file(entry, folder, "vertices");
    return at(entry, [&] { return open_vertices(file.file, file.path); });
}

Json entry_of(const Deformation& deformation, const std::filesystem::path& folder, const std::string& geometry)
{
    if (deformation.recipe.empty())
        throw Error(ErrorKind::cannot_write,
                    fmt::format("geometry '{}': deforms by code, which a scene file cannot describe", geometry));
    Json entry = Json::parse(deformation.recipe);
    if (entry.contains("file"))
        entry["file"] = portable_name(path_from(folder, path_of(entry["file"].get<std::string>())));
    return entry;
}

} // namespace oncollide
