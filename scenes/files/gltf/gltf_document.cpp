#include <oncollide/scenes/files/gltf/gltf_document.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/json/json_fault.hpp>

namespace oncollide {

namespace {

static_assert(std::endian::native == std::endian::little, "glTF is read as it lies");

constexpr std::array list_names = {"scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"};

/// Extensions that a file may require: only the first two affect the shape of a mesh.
constexpr std::array known_extensions = {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_texture_transform",
                                         "KHR_texture_basisu",    "KHR_lights_punctual",     "KHR_technique_webgl",
                                         "KHR_techniques_webgl",  "EXT_texture_webp",        "EXT_texture_avif"};
constexpr std::string_view materials = "KHR_materials_";

std::uint32_t number_at(std::string_view bytes, std::size_t at)
{
    std::uint32_t number;
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

} // namespace

Node list_of(const Node& node)
{
    node.size();
    return node;
}

GltfDocument::GltfDocument(const MeshSource& source) : source_(source), tape_({source.name})
{
    const std::string_view text =
        source.bytes.starts_with("glTF") ? split_glb() : without_byte_order_mark(source.bytes);
    try {
        const char* const end = tape_.read(text, 0);
        if (end != text.data() + text.size()) throw JsonFault{end};
    } catch (const JsonFault& fault) {
        explain_json(source.name, text, fault.where);
    }
    if (!root().has("asset")) source.fail("not a glTF file: it has no 'asset'");
    const std::string_view version = root()["asset"]["version"].text();
    if (!version.starts_with("2."))
        source.fail(fmt::format("the file is glTF version {}; only version 2 can be read", oncollide::quoted(version)));
    for (std::size_t list = 0; list < lists_.size(); ++list) {
        if (!root().has(list_names[list])) continue;
        const Node elements = root()[list_names[list]];
        lists_[list].reserve(elements.size());
        for (const Node& element : elements) lists_[list].push_back(element);
    }
    check_extensions();
}

/// Returns the JSON chunk and stores the binary chunk.
std::string_view GltfDocument::split_glb()
{
    constexpr std::size_t header_bytes = 12, chunk_header_bytes = 8;
    std::string_view rest = source_.bytes;
    if (rest.size() < header_bytes + chunk_header_bytes) source_.fail("truncated: the file ends within the GLB header");
    if (const std::uint32_t version = number_at(rest, 4); version != 2)
        source_.fail(fmt::format("the file is GLB version {}; only version 2 can be read", version));
    if (const std::uint32_t length = number_at(rest, 8); length != rest.size())
        source_.fail(fmt::format("the GLB header announces {} bytes, but the file has {}", length, rest.size()));
    rest.remove_prefix(header_bytes);
    std::string_view json;
    for (int number = 0; !rest.empty(); ++number) {
        if (rest.size() < chunk_header_bytes || number_at(rest, 0) > rest.size() - chunk_header_bytes)
            source_.fail(fmt::format("truncated: chunk {} of the GLB file goes beyond its end", number));
        const std::string_view kind = rest.substr(4, 4);
        const std::string_view chunk = rest.substr(chunk_header_bytes, number_at(rest, 0));
        if (number == 0) {
            if (kind != "JSON") source_.fail("the GLB file does not begin with a JSON chunk");
            json = chunk;
        } else if (number == 1 && kind == std::string_view("BIN\0", 4)) {
            binary_chunk_ = chunk;
        }
        rest.remove_prefix(chunk_header_bytes + chunk.size());
    }
    while (json.ends_with('\0')) json.remove_suffix(1); // some writers pad with zeros instead of blanks
    return json;
}

void GltfDocument::check_extensions()
{
    if (root().has("extensionsUsed"))
        for (const Node& name : list_of(root()["extensionsUsed"])) is_quantized_ |= name.text() == known_extensions[0];
    if (!root().has("extensionsRequired")) return;
    for (const Node& name : list_of(root()["extensionsRequired"])) {
        const std::string_view text = name.text();
        if (!text.starts_with(materials) &&
            std::find(known_extensions.begin(), known_extensions.end(), text) == known_extensions.end())
            name.fail(fmt::format("the extension {} is not supported; supported are {}, {}*", oncollide::quoted(text),
                                  fmt::join(known_extensions, ", "), materials));
        is_quantized_ |= text == known_extensions[0];
    }
}

std::size_t GltfDocument::index(List list, const Node& number) const
{
    const std::uint64_t place = number.natural();
    if (place >= lists_[list].size())
        number.fail(
            fmt::format("there is no {}[{}]; the file has {} of them", list_names[list], place, lists_[list].size()));
    return place;
}

} // namespace oncollide
