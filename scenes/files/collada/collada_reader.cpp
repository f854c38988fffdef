#include <algorithm>
#include <array>
#include <unordered_map>

#include <fmt/format.h>

#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/assembly/expanded_size.hpp>
#include <oncollide/scenes/files/assembly/placed_meshes.hpp>
#include <oncollide/scenes/files/collada/collada_mesh.hpp>
#include <oncollide/scenes/files/collada/collada_pose.hpp>
#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide {

namespace {

constexpr std::array kept_libraries = {"asset",         "library_geometries",    "library_controllers",
                                       "library_nodes", "library_visual_scenes", "scene"};

/// Application-specific data, materials and the like are dropped.
bool is_kept(std::string_view name, int level)
{
    if (level == 1) return std::ranges::find(kept_libraries, name) != kept_libraries.end();
    return name != "extra" && name != "technique" && name != "bind_material" && name != "Name_array" &&
           name != "IDREF_array";
}

class ColladaReader {
public:
    ColladaReader(const MeshSource& source, std::size_t most_parts)
        : source_(source), root_(read_xml_elements(source, is_kept)), expansion_(source, most_parts),
          geometries_(source), controllers_(source), nodes_(source), scenes_(source)
    {
        if (root_.name != "COLLADA")
            source.fail(fmt::format("not a COLLADA file: it holds <{}>", printable(root_.name)));
        for (const XmlElement& library : root_.children)
            for (const XmlElement& element : library.children) {
                if (element.name == "geometry") geometries_.add(element);
                if (element.name == "controller") controllers_.add(element);
                if (element.name == "visual_scene") scenes_.add(element);
                if (element.name == "node" || element.name == "visual_scene") add_nodes(element);
            }
    }

    RawMesh whole()
    {
        const XmlElement& scene = shown_scene();
        expansion_.expect(count(scene).pieces);
        expand(scene);
        return whole_mesh(source_, placed_, expansion_);
    }
    RawAssembly parts(const PartsReading& reading)
    {
        const XmlElement& scene = shown_scene();
        expansion_.expect_parts(count(scene).parts, shows_);
        expand(scene);
        return parts_of(source_, placed_, expansion_, reading);
    }

private:
    /// A node of the file during the traversal; instances may turn it into several nodes of the world.
    struct Open {
        const XmlElement* element;
        std::uint32_t above;
        Eigen::Affine3d pose; ///< pose of the parent node
    };

    /// Recursion; the reader limits the nesting of elements.
    void add_nodes(const XmlElement& element)
    {
        if (element.name == "node") nodes_.add(element);
        for (const XmlElement& child : element.children) {
            shows_ += is_shown(child);
            if (child.name == "node") add_nodes(child);
        }
    }

    /// The scene that the file selects; else the first.
    const XmlElement& shown_scene() const
    {
        const XmlElement* const scene = root_.find("scene");
        if (const XmlElement* const instance = scene ? scene->find("instance_visual_scene") : nullptr)
            return scenes_.find(*instance, "url");
        const XmlElement* const library = root_.find("library_visual_scenes");
        const XmlElement* const first = library ? library->find("visual_scene") : nullptr;
        if (!first) source_.fail("the file has no <visual_scene>, which would show its meshes");
        return *first;
    }

    /// The node that a child of a node or scene is, or instances; null: the child is not a node.
    const XmlElement* node_of(const XmlElement& child) const
    {
        if (child.name == "instance_node") return &nodes_.find(child, "url");
        return child.name == "node" ? &child : nullptr;
    }

    /// Counts the nodes and reads the meshes before anything is placed. Returns the size of the scene.
    ExpandedSize count(const XmlElement& scene)
    {
        ExpandedSize size;
        for (const XmlElement& child : scene.children)
            if (const XmlElement* const node = node_of(child)) size.add(size_of(*node, 1));
        expansion_.spend(size.nodes);
        return size;
    }
    ExpandedSize size_of(const XmlElement& node, int level)
    {
        const auto measure = [&] {
            ExpandedSize size{.nodes = 1};
            for (const XmlElement& child : node.children)
                if (is_shown(child)) {
                    Eigen::Affine3d pose = Eigen::Affine3d::Identity();
                    size.add({.nodes = 1, .parts = 1, .pieces = placed_.pieces(mesh_of(shown_by(child, pose)))});
                }
            for (const XmlElement& child : node.children)
                if (const XmlElement* const below = node_of(child)) size.add(size_of(*below, level + 1));
            return size;
        };
        return sizes_.of(&node, level, measure, [&] {
            source_.fail(fmt::format("nodes are nested deeper than {} levels; does {} instance itself?",
                                     XmlReader::most_levels, oncollide::quoted(name_of(node))),
                         node.line);
        });
    }

    void expand(const XmlElement& scene)
    {
        std::vector<Open> open;
        const auto add_children = [&](const XmlElement& element, std::uint32_t above, const Eigen::Affine3d& pose) {
            for (auto child = element.children.rbegin(); child != element.children.rend(); ++child)
                if (const XmlElement* const node = node_of(*child)) open.push_back({node, above, pose});
        };
        add_children(scene, no_node, collada_units(source_, root_));
        while (!open.empty()) {
            const Open node = open.back();
            open.pop_back();
            const auto number = static_cast<std::uint32_t>(placed_.nodes.size());
            const Eigen::Affine3d pose = node.pose * collada_pose(source_, *node.element);
            placed_.nodes.push_back({node.above, definition(*node.element)});
            for (const XmlElement& child : node.element->children)
                if (is_shown(child)) show(child, number, pose);
            add_children(*node.element, number, pose);
        }
        if (controllers_shown_ > 0)
            warn_of_file(source_.name,
                         fmt::format("{} mesh{} a skin or a morph, which is not applied: {} bind shape",
                                     controllers_shown_, controllers_shown_ == 1 ? " has" : "es have",
                                     controllers_shown_ == 1 ? "it stands in its" : "they stand in their"));
    }

    static bool is_shown(const XmlElement& child)
    {
        return child.name == "instance_geometry" || child.name == "instance_controller";
    }

    void show(const XmlElement& child, std::uint32_t node, Eigen::Affine3d pose)
    {
        const XmlElement& shown = shown_by(child, pose);
        controllers_shown_ += child.name == "instance_controller";
        placed_.shows.push_back({node, mesh_of(shown), pose});
        std::string& name = placed_.names[placed_.nodes[node].name];
        if (name.empty()) name = name_of(shown);
    }

    /// The geometry that an instance shows.
    /// @param pose  the pose of the instance; changed to the pose in which the geometry was bound to its bones
    const XmlElement& shown_by(const XmlElement& child, Eigen::Affine3d& pose) const
    {
        const XmlElement* shown =
            child.name == "instance_geometry" ? &geometries_.find(child, "url") : &controllers_.find(child, "url");
        for (int level = 0; shown->name == "controller"; ++level) {
            if (level > 8) source_.fail("controllers are their own sources", shown->line);
            const XmlElement* const skin = shown->find("skin");
            const XmlElement* const deforms = skin ? skin : shown->find("morph");
            if (!deforms) source_.fail("<controller> has neither <skin> nor <morph>", shown->line);
            if (const XmlElement* const bind = skin ? skin->find("bind_shape_matrix") : nullptr)
                pose = pose * collada_matrix(source_, *bind);
            shown = &source_of(*deforms);
        }
        return *shown;
    }

    /// The source of a controller: another controller, or a geometry.
    const XmlElement& source_of(const XmlElement& deforms) const
    {
        const XmlElement* const controller = controllers_.try_find(deforms.attribute("source"));
        return controller ? *controller : geometries_.find(deforms, "source");
    }

    static const std::string& name_of(const XmlElement& element)
    {
        const std::string& name = element.attribute("name");
        return name.empty() ? element.attribute("id") : name;
    }

    /// Index of the element's name.
    std::uint32_t definition(const XmlElement& node)
    {
        const auto [at, is_new] = definitions_.try_emplace(&node, static_cast<std::uint32_t>(placed_.names.size()));
        if (is_new) placed_.names.push_back(name_of(node));
        return at->second;
    }

    std::uint32_t mesh_of(const XmlElement& geometry)
    {
        const auto [at, is_new] = meshes_.try_emplace(&geometry, static_cast<std::uint32_t>(placed_.meshes.size()));
        if (is_new) placed_.meshes.push_back(read_collada_mesh(source_, geometry));
        return at->second;
    }

    const MeshSource& source_;
    const XmlElement root_;
    ExpansionLimit expansion_;
    ColladaIds geometries_, controllers_, nodes_, scenes_;
    std::uint64_t shows_ = 0; ///< instances of meshes that the file writes
    std::uint64_t controllers_shown_ = 0;
    ExpandedSizes sizes_{XmlReader::most_levels}; ///< sizes of nodes
    std::unordered_map<const XmlElement*, std::uint32_t> definitions_, meshes_;
    PlacedMeshes placed_;
};

} // namespace

RawMesh read_collada(const MeshSource& source)
{
    return ColladaReader(source, ExpansionLimit::any_parts).whole();
}

RawAssembly read_collada_parts(const MeshSource& source, const PartsReading& reading)
{
    return ColladaReader(source, reading.most_parts).parts(reading);
}

} // namespace oncollide
