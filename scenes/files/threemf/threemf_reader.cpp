#include <algorithm>
#include <map>
#include <unordered_map>

#include <fmt/format.h>

#include <oncollide/scenes/files/assembly/expanded_size.hpp>
#include <oncollide/scenes/files/assembly/placed_meshes.hpp>
#include <oncollide/scenes/files/threemf/model_part.hpp>
#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide {

namespace {

/// The path without the '/' that stands for the archive.
std::string in_archive(std::string_view path)
{
    path.remove_prefix(path.starts_with('/'));
    return std::string(path);
}

/// Finds the file of the archive that is the model.
class Relationships : public XmlHandler {
public:
    void begin(const XmlTag& tag) override
    {
        if (tag.name == "Relationship" && model.empty() &&
            tag["Type"] == "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel")
            model = in_archive(tag["Target"].value_or(""));
    }
    void end() override {}

    std::string model{};
};

class ThreeMfReader {
public:
    ThreeMfReader(const MeshSource& source, std::size_t most_parts)
        : source_(source), archive_(source), expansion_(source, most_parts), root_(model_file())
    {
        read_models(root_);
    }

    RawMesh whole()
    {
        expansion_.expect(count().pieces);
        expand();
        return whole_mesh(source_, placed_, expansion_);
    }
    RawAssembly parts(const PartsReading& reading)
    {
        expansion_.expect_parts(count().parts, references_);
        expand();
        return parts_of(source_, placed_, expansion_, reading);
    }

private:
    using Model = std::map<std::string, ModelPart>::value_type;

    /// An object during the traversal that makes nodes.
    struct Open {
        const ModelReference* reference;
        const Model* from; ///< the model that contains the reference
        std::uint32_t above;
        Eigen::Affine3d frame; ///< frame of the parent node, from that model's units
    };

    std::string model_file() const
    {
        const std::string file = "_rels/.rels";
        const MeshSource text{fmt::format("{}: {}", source_.name, file), {}};
        Relationships found;
        XmlReader reader(text, found);
        archive_.read(file, [&](std::string_view piece) { reader.read(piece); });
        reader.finish();
        if (found.model.empty()) text.fail("it names no 3D model");
        return found.model;
    }

    /// Reads the model and all models that it refers to.
    void read_models(const std::string& root)
    {
        std::vector<std::string> waiting = {root};
        while (!waiting.empty()) {
            const auto [model, is_new] = models_.try_emplace(std::move(waiting.back()));
            waiting.pop_back();
            if (!is_new) continue;
            model->second = read_model_part(source_, archive_, model->first, expansion_);
            const bool is_root = model->first == root;
            if (!is_root) model->second.build.clear(); // the specification uses only the root's build
            const auto note = [&](ModelReference& reference) {
                ++references_;
                if (reference.model.empty()) return;
                if (!is_root) // the specification requires a refusal
                    fail(reference, *model, "only the root model may refer to another model");
                waiting.push_back(reference.model = in_archive(reference.model));
            };
            std::ranges::for_each(model->second.build, note);
            for (auto& [id, object] : model->second.objects) std::ranges::for_each(object.components, note);
        }
    }

    struct Placed {
        const Model& model;
        std::uint32_t id;
        const ModelObject& object;
    };
    Placed placed(const ModelReference& reference, const Model& from) const
    {
        const Model& model = reference.model.empty() ? from : *models_.find(reference.model);
        const auto found = model.second.objects.find(reference.object);
        if (found == model.second.objects.end())
            fail(reference, from, fmt::format("there is no object {} in {}", reference.object, model.first));
        return {model, found->first, found->second};
    }
    [[noreturn]] void fail(const ModelReference& reference, const Model& from, const std::string& what) const
    {
        source_.fail(fmt::format("{}: line {}: {}", from.first, reference.line, what));
    }

    /// Counts the nodes and checks all references before anything is made. Returns the size of all elements.
    ExpandedSize count()
    {
        const Model& first = *models_.find(root_);
        ExpandedSize size;
        for (const ModelReference& item : first.second.build) size.add(size_of(item, first, 1));
        if (size.pieces == 0) source_.fail("the file holds no triangle");
        expansion_.spend(size.nodes);
        return size;
    }
    ExpandedSize size_of(const ModelReference& reference, const Model& from, int level)
    {
        const auto [model, id, object] = placed(reference, from);
        const auto measure = [&, &model = model, &object = object] {
            ExpandedSize size{.nodes = 1};
            if (!object.mesh.triangles.empty()) size.parts = 1, size.pieces = PlacedMeshes::pieces_of(object.mesh);
            for (const ModelReference& component : object.components) size.add(size_of(component, model, level + 1));
            return size;
        };
        return sizes_.of(&object, level, measure, [&, id = id] {
            fail(reference, from,
                 fmt::format("objects are nested deeper than {} levels; is object {} a component of itself?",
                             XmlReader::most_levels, id));
        });
    }

    void expand()
    {
        std::vector<Open> open;
        const auto add = [&](const std::vector<ModelReference>& references, const Model& model, std::uint32_t above,
                             const Eigen::Affine3d& pose) {
            for (auto reference = references.rbegin(); reference != references.rend(); ++reference)
                open.push_back({&*reference, &model, above, pose});
        };
        const Model& first = *models_.find(root_);
        add(first.second.build, first, no_node, Eigen::Affine3d(Eigen::Scaling(first.second.metres)));
        while (!open.empty()) {
            const Open next = open.back();
            open.pop_back();
            const auto [model, id, object] = placed(*next.reference, *next.from);
            Eigen::Affine3d pose = next.frame * next.reference->pose;
            if (model.second.metres != next.from->second.metres)
                pose.scale(model.second.metres / next.from->second.metres);
            const auto number = static_cast<std::uint32_t>(placed_.nodes.size());
            placed_.nodes.push_back({next.above, definition(object, id)});
            if (!object.mesh.triangles.empty()) placed_.shows.push_back({number, mesh_of(object), pose});
            add(object.components, model, number, pose);
        }
    }

    /// Index of the object's name.
    std::uint32_t definition(const ModelObject& object, std::uint32_t id)
    {
        const auto [at, is_new] = definitions_.try_emplace(&object, static_cast<std::uint32_t>(placed_.names.size()));
        if (is_new) placed_.names.push_back(object.name.empty() ? fmt::format("object {}", id) : object.name);
        return at->second;
    }
    std::uint32_t mesh_of(const ModelObject& object)
    {
        const auto [at, is_new] = meshes_.try_emplace(&object, static_cast<std::uint32_t>(placed_.meshes.size()));
        if (is_new) placed_.meshes.push_back(object.mesh);
        return at->second;
    }

    const MeshSource& source_;
    const ZipArchive archive_;
    ExpansionLimit expansion_;
    const std::string root_; ///< the model that has the build
    std::map<std::string, ModelPart> models_;
    std::uint64_t references_ = 0;                ///< items and components that the file writes
    ExpandedSizes sizes_{XmlReader::most_levels}; ///< sizes of objects
    std::unordered_map<const ModelObject*, std::uint32_t> definitions_, meshes_;
    PlacedMeshes placed_;
};

} // namespace

RawMesh read_3mf(const MeshSource& source)
{
    return ThreeMfReader(source, ExpansionLimit::any_parts).whole();
}

RawAssembly read_3mf_parts(const MeshSource& source, const PartsReading& reading)
{
    return ThreeMfReader(source, reading.most_parts).parts(reading);
}

} // namespace oncollide
