#include <oncollide/samples/sample_geometry.hpp>

#include <fmt/format.h>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/generators.hpp>

namespace oncollide {

namespace {

/// Limit of generators' parameters in a file: a typing error should not fill the memory.
constexpr int most_per_recipe = 10'000'000;

int count(const Node& node, std::string_view key, int most = most_per_recipe)
{
    return static_cast<int>(node[key].integer(1, most));
}

double size(const Node& node, std::string_view key)
{
    node[key]; // must exist
    return node.positive(key, 0);
}

std::uint64_t seed(const Node& node)
{
    return node.has("seed") ? node["seed"].natural() : 1;
}

class SampleGenerators : public Generators {
public:
    Mesh mesh(const Node& node) const override
    {
        const std::string_view kind = node["kind"].text();
        if (kind == "box") return node.only({"kind", "half"}), make_box_mesh(node["half"].vector3());
        if (kind == "sphere") {
            node.only({"kind", "radius", "triangles"});
            return make_sphere_mesh(size(node, "radius"), count(node, "triangles"));
        }
        if (kind == "torus") {
            node.only({"kind", "major", "minor", "triangles"});
            return make_torus_mesh(size(node, "major"), size(node, "minor"), count(node, "triangles"));
        }
        if (kind == "torus_knot") {
            node.only({"kind", "p", "q", "major", "minor", "tube", "triangles"});
            return make_torus_knot_mesh(count(node, "p", 1000), count(node, "q", 1000), size(node, "major"),
                                        size(node, "minor"), size(node, "tube"), count(node, "triangles"));
        }
        if (kind == "gear") {
            node.only({"kind", "teeth", "root_radius", "tip_radius", "thickness", "bore_radius"});
            return make_gear_mesh(count(node, "teeth", 100'000), size(node, "root_radius"), size(node, "tip_radius"),
                                  size(node, "thickness"), size(node, "bore_radius"));
        }
        if (kind == "sheet") {
            node.only({"kind", "size", "cells"});
            Eigen::Vector2d sides, cells;
            node["size"].numbers(2, sides.data()), node["cells"].numbers(2, cells.data());
            const auto whole = [&](const Node& count) { return static_cast<int>(count.integer(1, 2000)); };
            return make_sheet_mesh(sides, {whole(node["cells"][0]), whole(node["cells"][1])});
        }
        if (kind == "terrain") {
            node.only({"kind", "size", "height", "cells", "seed"});
            return make_terrain_mesh(size(node, "size"), size(node, "height"), count(node, "cells", 2000), seed(node));
        }
        if (kind == "hills") {
            node.only({"kind", "cells", "spacing", "height", "seed", "x", "y", "size"});
            const auto whole = [&](const char* key) {
                return static_cast<std::uint32_t>(node[key].integer(0, 20'000));
            };
            return make_hills_mesh(whole("cells"), size(node, "spacing"), size(node, "height"), seed(node), whole("x"),
                                   whole("y"), static_cast<std::uint32_t>(count(node, "size", 2000)));
        }
        if (kind == "needles") {
            node.only({"kind", "count", "length", "aspect", "size", "seed"});
            return make_needles_mesh(count(node, "count"), size(node, "length"), size(node, "aspect"),
                                     size(node, "size"), seed(node));
        }
        if (kind == "soup") {
            node.only({"kind", "count", "edge", "size", "seed"});
            return make_soup_mesh(count(node, "count"), size(node, "edge"), size(node, "size"), seed(node));
        }
        node["kind"].fail(fmt::format("no generator named '{}'{}", kind,
                                      valid_names(kind, {"box", "sphere", "torus", "torus_knot", "gear", "sheet",
                                                         "terrain", "hills", "needles", "soup"})));
    }

    OccupancyMap building(const Node& node) const override
    {
        node.only({"rooms", "resolution", "seed"});
        return make_building_map(count(node, "rooms", 100), size(node, "resolution"), seed(node));
    }

    Terrain hills(const Node& hills) const override
    {
        hills.only({"cells", "spacing", "height", "seed"});
        constexpr int most = 20'000;
        const Node cells = hills["cells"];
        const bool two = cells.is_array();
        if (two && cells.size() != 2) cells.fail("must be one number or two");
        const auto x = static_cast<std::uint32_t>((two ? cells[0] : cells).integer(1, most)),
                   y = static_cast<std::uint32_t>((two ? cells[1] : cells).integer(1, most));
        if (std::uint64_t(x) * y > most_per_recipe)
            cells.fail(fmt::format("{} x {} cells; at most {} in all", x, y, most_per_recipe));
        return make_hills(x, y, size(hills, "spacing"), size(hills, "height"), seed(hills));
    }
};

} // namespace

const Generators& sample_generators()
{
    static const SampleGenerators generators;
    return generators;
}

GeometryId add_geometry(SceneInfo& scene, const std::string& name, const Json& entry)
{
    const std::string text = entry.dump();
    JsonTape tape({name});
    tape.read(text, 0);
    return add_geometry(scene, name, Node(tape), {}, {.generators = &sample_generators()});
}

} // namespace oncollide
