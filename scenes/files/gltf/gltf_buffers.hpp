#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/files/gltf/gltf_document.hpp>

namespace oncollide {

/// The bytes that the buffers of a glTF file hold: in GLB's binary chunk, in the file itself (base64) or in files
/// beside it. Each is read once, when it is first needed. Private to scenes.
class GltfBuffers {
public:
    explicit GltfBuffers(const GltfDocument& document);

    /// The bytes of the buffer view of that number, which stay as long as this. Throws Error{bad_data} where they are
    /// not all there.
    std::string_view view(const Node& number);
    /// Bytes of the files read so far.
    std::uint64_t bytes_read() const { return bytes_read_; }

private:
    std::string_view buffer(const Node& number);
    std::string_view load(std::size_t number);
    const std::string& beside(const Node& uri);

    const GltfDocument& document_;
    std::vector<std::optional<std::string_view>> buffers_; ///< by number
    std::deque<std::string> decoded_;
    std::map<std::string, std::string> files_; ///< by name: many buffers may name one
    std::uint64_t bytes_read_ = 0;
};

} // namespace oncollide
