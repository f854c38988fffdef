#include <oncollide/scenes/files/threemf/model_part.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide {

namespace {

constexpr std::string_view core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
constexpr std::string_view production = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";

/// Extensions that a file may require: none affects the shape of a mesh, except production, which is supported.
constexpr std::array supported_extensions = {
    production, std::string_view("http://schemas.microsoft.com/3dmanufacturing/material/2015/02"),
    std::string_view("http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07")};

struct Unit {
    std::string_view name;
    double metres;
};
constexpr Unit units[] = {{"micron", 1e-6}, {"millimeter", 1e-3}, {"centimeter", 1e-2},
                          {"inch", 0.0254}, {"foot", 0.3048},     {"meter", 1}};

/// Position of an element in a model.
enum class Place {
    outside,
    model,
    resources,
    object,
    mesh,
    vertices,
    vertex,
    triangles,
    triangle,
    components,
    component,
    build,
    item,
    elsewhere
};

struct Step {
    Place above;
    std::string_view name;
    Place place;
};
constexpr Step steps[] = {{Place::vertices, "vertex", Place::vertex},
                          {Place::triangles, "triangle", Place::triangle},
                          {Place::outside, "model", Place::model},
                          {Place::model, "resources", Place::resources},
                          {Place::resources, "object", Place::object},
                          {Place::object, "mesh", Place::mesh},
                          {Place::mesh, "vertices", Place::vertices},
                          {Place::mesh, "triangles", Place::triangles},
                          {Place::object, "components", Place::components},
                          {Place::components, "component", Place::component},
                          {Place::model, "build", Place::build},
                          {Place::build, "item", Place::item}};

/// Elements of other namespaces and their contents are ignored: an extension that affects shapes must be required.
Place place_of(Place above, const XmlTag& tag)
{
    if (tag.space != core) return Place::elsewhere;
    for (const Step& step : steps)
        if (step.above == above && step.name == tag.name) return step.place;
    return Place::elsewhere;
}

class ModelHandler : public XmlHandler {
public:
    ModelHandler(const MeshSource& source, ExpansionLimit& expansion) : source_(source), expansion_(expansion) {}

    void name_space(std::string_view prefix, std::string_view name) override
    {
        if (places_.empty()) spaces_[std::string(prefix)] = name;
    }

    void begin(const XmlTag& tag) override
    {
        tag_ = &tag;
        const Place place = place_of(places_.empty() ? Place::outside : places_.back(), tag);
        switch (place) {
        case Place::model:
            read_model();
            break;
        case Place::object:
            read_object();
            break;
        case Place::vertex:
            read_vertex();
            break;
        case Place::triangle:
            read_triangle();
            break;
        case Place::component:
            object_->components.push_back(reference());
            break;
        case Place::item:
            part.build.push_back(reference());
            break;
        default:
            if (places_.empty())
                fail(fmt::format("not a 3MF model: it holds <{}> of the namespace {}", printable(tag.name),
                                 oncollide::quoted(tag.space)));
        }
        places_.push_back(place);
    }

    void end() override { places_.pop_back(); }

    ModelPart part{};

private:
    [[noreturn]] void fail(const std::string& what) const { source_.fail(what, tag_->line); }

    void read_model()
    {
        if (const auto name = (*tag_)["unit"]) {
            const auto unit = std::ranges::find(units, *name, &Unit::name);
            if (unit == std::end(units))
                fail(fmt::format("the unit is {}; it must be micron, millimeter, centimeter, inch, foot or meter",
                                 oncollide::quoted(*name)));
            part.metres = unit->metres;
        }
        each_word((*tag_)["requiredextensions"].value_or(""), [&](std::string_view prefix) {
            const std::string& name = spaces_[std::string(prefix)];
            if (std::ranges::find(supported_extensions, name) == supported_extensions.end())
                fail(fmt::format("the extension {} ({}) is not supported; supported are {}", oncollide::quoted(prefix),
                                 oncollide::quoted(name), fmt::join(supported_extensions, ", ")));
        });
    }

    template <class Visit>
    static void each_word(std::string_view words, Visit visit)
    {
        constexpr const char* blanks = " \t\r\n";
        for (std::size_t begin = words.find_first_not_of(blanks); begin != words.npos;
             begin = words.find_first_not_of(blanks, begin)) {
            const std::size_t end = std::min(words.find_first_of(blanks, begin), words.size());
            visit(words.substr(begin, end - begin));
            begin = end;
        }
    }

    std::string_view text(std::string_view attribute) const
    {
        const auto found = (*tag_)[attribute];
        if (!found) fail(fmt::format("<{}> has no {}", tag_->name, attribute));
        return *found;
    }
    double coordinate(std::string_view attribute) const
    {
        double value = 0;
        if (!parse(text(attribute), value) || !std::isfinite(value))
            fail(fmt::format("coordinate {} is {}; it must be a finite number", attribute,
                             oncollide::quoted(text(attribute))));
        return value;
    }
    std::uint32_t natural(std::string_view attribute) const
    {
        const std::string_view word = text(attribute);
        std::uint32_t value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size())
            fail(fmt::format("{} of <{}> is {}; it must be a whole number", attribute, tag_->name,
                             oncollide::quoted(word)));
        return value;
    }

    void read_object()
    {
        const std::uint32_t id = natural("id");
        const auto [at, is_new] = part.objects.try_emplace(id);
        if (!is_new) fail(fmt::format("a second object has the id {}", id));
        object_ = &at->second;
        object_->line = tag_->line;
        object_->name = (*tag_)["name"].value_or("");
    }
    void read_vertex()
    {
        expansion_.spend(1);
        object_->mesh.vertices.emplace_back(coordinate("x"), coordinate("y"), coordinate("z"));
    }
    void read_triangle()
    {
        expansion_.spend(1);
        const Triangle triangle = {natural("v1"), natural("v2"), natural("v3")};
        const std::size_t vertices = object_->mesh.vertices.size();
        for (const std::uint32_t v : triangle)
            if (v >= vertices)
                fail(fmt::format("the triangle uses vertex {}, but the mesh has {} vertices", v, vertices));
        object_->mesh.triangles.push_back(triangle);
    }

    ModelReference reference()
    {
        static const std::string path = fmt::format("{}\npath", production);
        expansion_.spend(1);
        ModelReference found{std::string((*tag_)[path].value_or("")), natural("objectid"), Eigen::Affine3d::Identity(),
                             tag_->line};
        if (const auto numbers = (*tag_)["transform"]) found.pose = transform(*numbers);
        return found;
    }
    /// Parses the rows of the matrix by which row vectors are multiplied.
    Eigen::Affine3d transform(std::string_view words) const
    {
        std::vector<double> numbers;
        each_word(words, [&](std::string_view word) {
            double number = 0;
            if (!parse(word, number) || !std::isfinite(number))
                fail(fmt::format("the transform holds {}; it must be 12 finite numbers", oncollide::quoted(word)));
            numbers.push_back(number);
        });
        if (numbers.size() != 12) fail(fmt::format("the transform has {} numbers; it must have 12", numbers.size()));
        Eigen::Affine3d pose = Eigen::Affine3d::Identity();
        pose.matrix().topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4>>(numbers.data());
        return pose;
    }

    const MeshSource& source_;
    ExpansionLimit& expansion_;
    const XmlTag* tag_ = nullptr;               ///< the element being read
    std::vector<Place> places_;                 ///< from the root to the element being read
    std::map<std::string, std::string> spaces_; ///< by prefix
    ModelObject* object_ = nullptr;
};

} // namespace

ModelPart read_model_part(const MeshSource& source, const ZipArchive& archive, const std::string& file,
                          ExpansionLimit& expansion)
{
    const MeshSource text{fmt::format("{}: {}", source.name, file), {}};
    ModelHandler handler(text, expansion);
    XmlReader reader(text, handler);
    archive.read(file, [&](std::string_view piece) { reader.read(piece); });
    reader.finish();
    return std::move(handler.part);
}

} // namespace oncollide
