#pragma once
#include <memory>

#include <oncollide/scenes/geometry.hpp>

namespace oncollide::web {

/// A geometry that JavaScript holds, until oc_geometry_free().
struct HeldGeometry {
    std::shared_ptr<const Geometry> geometry;
};

} // namespace oncollide::web
