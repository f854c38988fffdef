#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <variant>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/shape.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

class CookedMesh;

/// The size of a cooked file.
struct CookedSize {
    std::uint64_t bytes = 0;
    std::uint32_t chunks = 0;
};

/// The last alternative is a mesh in a cooked file, which is read in parts as tests need them
/// (scenes/cooked/cooked_mesh.hpp).
using GeometryData = std::variant<Mesh, Shape, OccupancyMap, Terrain, std::shared_ptr<const CookedMesh>>;

/// A geometry in its own frame. Several bodies may share it.
struct Geometry {
    std::string name;
    GeometryData data;
    /// The entry of a scene file that makes this geometry again (JSON text: file or generator; paths absolute or
    /// relative to the current folder). Empty for geometries made in code, and for shapes, whose data is a complete
    /// description.
    std::string recipe;
};

/// The exact AABB of a geometry in its own frame.
ONCOLLIDE_API Aabb bounds_of(const GeometryData& geometry);
ONCOLLIDE_API Aabb bounds_of(const Geometry& geometry);

/// Throws Error{bad_data} naming `name` for a geometry made in code that check_mesh or check_shape refuses, and for a
/// null cooked mesh. Cost: as for these two checks.
ONCOLLIDE_API void check_geometry(const std::string& name, const GeometryData& geometry);

} // namespace oncollide
