#pragma once
#include <string>

#include <oncollide/scenes/files/geometry_recipe.hpp>

namespace oncollide {

/// Adds a geometry that is described as in a scene file; relative paths start from the current folder. Private to the
/// samples.
GeometryId add_geometry(SceneInfo& scene, const std::string& name, const Json& entry);

} // namespace oncollide
