#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// Keeps `count` meshes as cooked tiles under a name that says all of what they are, unless they are there already, and
/// returns their index. make(i) may be called by many threads at once.
using KeepTiles = std::function<std::filesystem::path(const std::string& name, std::size_t count,
                                                      const std::function<Mesh(std::size_t)>& make)>;

struct CatalogueOptions {
    std::optional<int> bodies{}; ///< how many, where the scene lets one choose
    std::optional<int> frames{};
    std::uint64_t seed = 12345;
    std::filesystem::path data{}; ///< folder with meshes/ and octomap/; empty or missing: generated stand-ins
    BodySink* sink = nullptr;     ///< takes the bodies; null: the scene holds them
    KeepTiles tiles{};            ///< null: the ground of the scene `tiles` is held as meshes
};

struct CatalogueEntry {
    std::string name, summary;
};

/// Every scene of the catalogue, in the order to show them.
const std::vector<CatalogueEntry>& catalogue();

/// Makes a scene by name. Throws Error{usage} for an unknown name (lists the known ones) or absurd options.
Scene make_scene(const std::string& name, const CatalogueOptions& options = {});

} // namespace oncollide
