#pragma once
#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// Makes the geometries that a scene file describes by the parameters of a generator (docs/scene-format.md). The
/// functions throw Error{usage} or Error{bad_data}.
class Generators {
public:
    virtual ~Generators() = default;
    virtual Mesh mesh(const Node& generate) const = 0;
    virtual OccupancyMap building(const Node& building) const = 0;
    virtual Terrain hills(const Node& hills) const = 0;
};

} // namespace oncollide
