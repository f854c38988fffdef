#pragma once
#include "tools/command/clash/clash_fixture.hpp"

namespace oncollide::test {

/// A building model; a shell script stands for the converter of IFC, whose own tests are in clients/ifc.
class BuildingModel : public ClashCommand {
protected:
    /// An element: a box of length x 1 x 1 m whose least corner is at (x, 0, 0).
    struct Element {
        std::string part_class, name, guid, storey;
        double x, length = 1;
    };

    /// Writes model.ifc, and a converter that turns it into these elements.
    void write_model(const std::vector<Element>& elements, const std::string& discipline = "model")
    {
        std::string corners;
        for (int k = 0; k < 8; ++k)
            for (const float x : {float(k & 1), float(k / 2 & 1), float(k / 4)})
                corners.append(reinterpret_cast<const char*>(&x), sizeof x);
        for (const char i : {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                             2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5})
            corners += i;
        using nlohmann::json;
        json nodes = json::array(), roots = json::array();
        for (const Element& of : elements) {
            roots.push_back(nodes.size());
            nodes.push_back({{"name", of.name},
                             {"mesh", 0},
                             {"translation", {of.x, 0, 0}},
                             {"scale", {of.length, 1, 1}},
                             {"extras",
                              {{"class", of.part_class},
                               {"guid", of.guid},
                               {"storey", of.storey},
                               {"discipline", discipline},
                               {"type", ""}}}});
        }
        const nlohmann::json gltf{
            {"asset", {{"version", "2.0"}}},
            {"scenes", {{{"nodes", roots}}}},
            {"nodes", nodes},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
            {"accessors",
             {{{"bufferView", 0}, {"componentType", 5126}, {"count", 8}, {"type", "VEC3"}},
              {{"bufferView", 1}, {"componentType", 5121}, {"count", 36}, {"type", "SCALAR"}}}},
            {"bufferViews",
             {{{"buffer", 0}, {"byteLength", 96}}, {{"buffer", 0}, {"byteOffset", 96}, {"byteLength", 36}}}},
            {"buffers", {{{"byteLength", 132}, {"uri", (folder_ / "corners.bin").string()}}}}};
        folder_.write("corners.bin", corners), folder_.write("model.ifc", "ISO-10303-21;");
        folder_.write("model.gltf", gltf.dump());
        std::filesystem::permissions(
            folder_.write("converter", "#!/bin/sh\ncp '" + (folder_ / "model.gltf").string() + "' $3\n"),
            std::filesystem::perms::owner_all);
    }
    Outcome clash_model(std::vector<std::string> more)
    {
        more.insert(more.begin(), {"clash", "model.ifc", "--units", "m"});
        Surroundings around;
        around.environment = {{"ONCOLLIDE_IFC", (folder_ / "converter").string()}};
        return run(std::move(more), around);
    }
};

} // namespace oncollide::test
