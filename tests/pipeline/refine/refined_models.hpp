#pragma once
#include <memory>
#include <vector>

#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {

/// A store of models without trees, about 2 m large and centred, except for half-spaces.
struct RefinedModels {
    explicit RefinedModels(const Settings& settings) : store(settings, make_cpu_backend()) {}

    Model& add(GeometryData data)
    {
        return store[store.add(std::make_shared<const Geometry>(Geometry{{}, std::move(data), {}}))];
    }
    Model& add(Kind kind)
    {
        switch (kind) {
        case Kind::mesh:
            return add(make_sphere_mesh(1, 512));
        case Kind::terrain: {
            TerrainGrid grid{.columns = 3, .rows = 3};
            grid.origin = {-1, -1, 0};
            return add(make_terrain("hills", grid, std::vector<double>{0, 0.25, 0, 0.5, 0, 0.25, 0, 0.25, 0}));
        }
        case Kind::map:
            return add(make_occupancy_map("map", 1, std::vector<MapCell>{{-1, -1, -1, 1}, {0, 0, 0, 1}}));
        case Kind::polytope:
            return add(Shape(Box{{1, 1, 1}}));
        case Kind::round:
            return add(Shape(Sphere{1}));
        case Kind::half_space:
            break;
        }
        return add(Shape(HalfSpace{}));
    }

    ModelStore store;
};

} // namespace oncollide::test
