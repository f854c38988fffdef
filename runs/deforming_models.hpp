#pragma once
#include <oncollide/pipeline/models.hpp>
#include <oncollide/scenes/columns.hpp>

namespace oncollide {

// The geometries of a scene as models of a World. Private to the project.

/// Adds geometry `g`. If it deforms, the World owns its vertices from the beginning, so that boxes are the same whether
/// they have moved before or not.
ModelId add_model(Models& models, const GeometryList& geometries, std::uint32_t g);
/// Passes on that the geometry of a model is another one: its vertices if it deforms.
void renew_model(Models& models, ModelId model, const GeometryList& geometries, std::uint32_t g);
/// Throws Error{usage} if a geometry deforms: contacts on the way from frame to frame are found for rigid motions.
void check_rigid(const GeometryList& geometries);

} // namespace oncollide
