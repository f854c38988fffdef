#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

class Generators;

/// Stores `count` meshes as cooked tiles under a name that identifies their contents, unless they exist already, and
/// returns the index file. Several threads may call make(i) at the same time.
using KeepTiles = std::function<std::filesystem::path(const std::string& name, std::size_t count,
                                                      const std::function<Mesh(std::size_t)>& make)>;

struct CatalogueOptions {
    std::optional<int> bodies{}; ///< number of bodies, for scenes that let the caller choose
    std::optional<int> frames{};
    std::uint64_t seed = 12345;
    std::filesystem::path data{}; ///< folder with meshes/ and octomap/; empty or missing: generated stand-ins
    KeepTiles tiles{};            ///< null: the scene `tiles` holds its ground as meshes
};

struct CatalogueEntry {
    std::string name, summary;
};

/// Every scene of the catalogue, in the order for display.
ONCOLLIDE_API const std::vector<CatalogueEntry>& catalogue();

/// For load_scene(): makes the geometries that a scene file describes by generators.
ONCOLLIDE_API const Generators& sample_generators();

/// Makes a scene by name. Throws Error{usage} for an unknown name (lists the known ones) or options out of range.
ONCOLLIDE_API Scene make_scene(const std::string& name, const CatalogueOptions& options = {});
/// The same for a scene too large to store: hands its bodies to `sink` and returns the rest.
ONCOLLIDE_API SceneInfo make_scene(const std::string& name, BodySink& sink, const CatalogueOptions& options = {});

} // namespace oncollide
