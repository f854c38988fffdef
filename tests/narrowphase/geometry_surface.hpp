#pragma once
#include <memory>

#include <oncollide/narrowphase/model.hpp>

namespace oncollide {

// The root cell of a model of the geometry.
inline RootCell root_cell_of(const Geometry& geometry)
{
    return Model(std::make_shared<const Geometry>(geometry)).root_cell();
}
inline Surface make_surface(const Geometry& geometry, const RootCell& root)
{
    return Model(std::make_shared<const Geometry>(geometry)).surface(root);
}

} // namespace oncollide
