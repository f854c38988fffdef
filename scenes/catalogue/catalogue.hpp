#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

struct CatalogueOptions {
    std::optional<int> bodies{}; ///< how many, where the scene lets one choose
    std::optional<int> frames{};
    std::uint64_t seed = 12345;
    std::filesystem::path data{}; ///< folder with meshes/ and octomap/; empty or missing: generated stand-ins
    BodySink* sink = nullptr;     ///< takes the bodies; null: the scene holds them
};

struct CatalogueEntry {
    std::string name, summary;
};

/// Every scene of the catalogue, in the order to show them.
const std::vector<CatalogueEntry>& catalogue();

/// Makes a scene by name. Throws Error{usage} for an unknown name (lists the known ones) or absurd options.
Scene make_scene(const std::string& name, const CatalogueOptions& options = {});

} // namespace oncollide
