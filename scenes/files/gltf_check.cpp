#include <oncollide/scenes/files/gltf_check.hpp>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace oncollide {

namespace {

using Json = nlohmann::json;

constexpr int deepest_json = 100, deepest_node = 500;
constexpr std::size_t most_per_file = 50'000'000;

/// The JSON chunk of a GLB file, or the whole of a glTF file.
std::string_view json_text(const MeshSource& source)
{
    const std::string_view bytes = source.bytes;
    if (!bytes.starts_with("glTF")) return bytes;
    constexpr std::size_t header_bytes = 20;
    if (bytes.size() < header_bytes) source.fail("truncated: the file ends within the GLB header");
    std::uint32_t version, length, chunk;
    std::memcpy(&version, &bytes[4], 4), std::memcpy(&length, &bytes[8], 4), std::memcpy(&chunk, &bytes[12], 4);
    if (version != 2) source.fail(fmt::format("the file is GLB version {}; only version 2 can be read", version));
    if (length != bytes.size())
        source.fail(fmt::format("the GLB header announces {} bytes, but the file has {}", length, bytes.size()));
    if (bytes.substr(16, 4) != "JSON" || chunk > bytes.size() - header_bytes)
        source.fail("the GLB file does not begin with a whole JSON chunk");
    return bytes.substr(header_bytes, chunk);
}

/// Assimp's JSON reader calls itself for every level.
void check_nesting(const MeshSource& source, std::string_view text)
{
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                in_string = false;
            continue;
        }
        in_string = c == '"';
        depth += (c == '[' || c == '{') - (c == ']' || c == '}');
        if (depth > deepest_json) source.fail(fmt::format("the JSON is nested deeper than {} levels", deepest_json));
    }
}

/// Walks the nodes of the scene that a reader shows.
class SceneCheck {
public:
    SceneCheck(const MeshSource& source, const Json& file) : source_(source), file_(file) {}

    /// Buffers in files of their own are there and long enough: Assimp leaks the open file otherwise.
    void check_buffers() const
    {
        const std::filesystem::path folder = std::filesystem::path(source_.name).parent_path();
        for (const Json& buffer : file_.value("buffers", Json::array())) {
            const std::string uri = buffer.value("uri", "");
            if (uri.empty() || uri.starts_with("data:") || uri.find('%') != uri.npos) continue;
            const auto needed = buffer.at("byteLength").get<std::uint64_t>();
            std::error_code error;
            const std::uintmax_t size = std::filesystem::file_size(folder / uri, error);
            if (error) source_.fail(fmt::format("the file of its buffer, {}, cannot be read", oncollide::quoted(uri)));
            if (size < needed)
                source_.fail(fmt::format("truncated: the file of its buffer, {}, has {} of {} bytes",
                                         oncollide::quoted(uri), size, needed));
        }
    }

    std::size_t count_triangles()
    {
        for (const Json& accessor : file_.value("accessors", Json::array()))
            if (accessor.contains("sparse")) source_.fail("sparse accessors are not supported; expand them");
        visited_.assign(file_.value("nodes", Json::array()).size(), false);
        if (file_.contains("scenes"))
            for (const Json& node : at("scenes", file_.value("scene", Json(0u))).value("nodes", Json::array()))
                visit(node, 0);
        return triangles_;
    }

private:
    const Json& at(const char* array, const Json& index) const
    {
        const auto found = file_.find(array);
        const std::size_t size = found == file_.end() ? 0 : found->size();
        if (!index.is_number_unsigned() || index.get<std::size_t>() >= size)
            source_.fail(fmt::format("{}[{}] is used, but the file has {} {}", array, index.dump(), size, array));
        return (*found)[index.get<std::size_t>()];
    }

    void visit(const Json& index, int depth)
    {
        const Json& node = at("nodes", index);
        if (depth > deepest_node) source_.fail(fmt::format("the nodes are nested deeper than {} levels", deepest_node));
        if (visited_[index.get<std::size_t>()])
            source_.fail(fmt::format("nodes[{}] has two parents; nodes must form a tree", index.dump()));
        visited_[index.get<std::size_t>()] = true;
        if (const auto mesh = node.find("mesh"); mesh != node.end())
            for (const Json& primitive : at("meshes", *mesh).at("primitives")) add_primitive(primitive);
        for (const Json& child : node.value("children", Json::array())) visit(child, depth + 1);
    }

    /// Assimp reads any others as whole numbers too, and falls over what it finds.
    void check_indices(const Json& accessor) const
    {
        const int type = accessor.value("componentType", 0); // 8, 16 or 32 bits without sign
        if (accessor.value("type", "") != "SCALAR" || (type != 5121 && type != 5123 && type != 5125))
            source_.fail("an accessor of indices is not made of whole numbers (SCALAR, 5121, 5123 or 5125)");
    }

    void add_primitive(const Json& primitive)
    {
        const Json& positions = at("accessors", primitive.at("attributes").at("POSITION"));
        if (positions.value("type", "") != "VEC3" || positions.value("componentType", 0) != 5126)
            source_.fail("an accessor of positions is not made of three floats (VEC3, 5126)");
        if (const auto view = positions.find("bufferView"); view != positions.end())
            if (const std::size_t stride = at("bufferViews", *view).value("byteStride", std::size_t(12)); stride < 12)
                source_.fail(fmt::format("positions lie {} bytes apart, but take 12", stride));
        const auto indices = primitive.find("indices");
        const Json& corners = indices == primitive.end() ? positions : at("accessors", *indices);
        if (indices != primitive.end()) check_indices(corners);
        const auto count = corners.at("count").get<std::size_t>();
        if (count > most_per_file) source_.fail(fmt::format("a primitive has more than {} corners", most_per_file));

        const int mode = primitive.value("mode", 4);
        if (mode < 0 || mode > 6) source_.fail(fmt::format("a primitive has mode {}; modes are 0 to 6", mode));
        if (mode == 2 && indices != primitive.end()) // Assimp ends them with their first line, even if it left that out
            source_.fail(
                "line loops (mode 2) with indices are not supported; leave them out, or make them line strips");
        if ((mode == 2 || mode == 3) && count < 2) source_.fail(fmt::format("{} corners make no line", count));
        if (mode < 4) return; // points and lines
        if (mode == 4 ? count % 3 != 0 : count < 3)
            source_.fail(fmt::format("{} corners make no whole triangles", count));
        triangles_ += mode == 4 ? count / 3 : count - 2;
        if (triangles_ > most_per_file)
            source_.fail(fmt::format("the scene has more than {} triangles", most_per_file));
    }

    const MeshSource& source_;
    const Json& file_;
    std::vector<bool> visited_;
    std::size_t triangles_ = 0;
};

/// The first line of nlohmann's message, without its prefix `[json.exception.type_error.302] `.
std::string reason_of(const std::string& message)
{
    const std::size_t prefix = message.find("] ");
    const std::string text = message.substr(prefix == message.npos ? 0 : prefix + 2);
    return text.substr(0, text.find('\n'));
}

} // namespace

std::size_t check_gltf(const MeshSource& source)
{
    const std::string_view text = json_text(source);
    check_nesting(source, text);
    try {
        const Json file = Json::parse(text);
        const std::string version = file.at("asset").at("version").get<std::string>();
        if (!version.starts_with("2."))
            source.fail(
                fmt::format("the file is glTF version {}; only version 2 can be read", oncollide::quoted(version)));
        SceneCheck check(source, file);
        check.check_buffers();
        return check.count_triangles();
    } catch (const Json::exception& error) {
        source.fail(fmt::format("not a valid glTF file: {}", reason_of(error.what())));
    }
}

} // namespace oncollide
