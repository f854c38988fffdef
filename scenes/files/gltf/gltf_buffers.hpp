#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/files/gltf/gltf_document.hpp>

namespace oncollide {

/// The bytes of the buffers of a glTF file: in GLB's binary chunk, in the file itself (base64) or in separate files.
/// Each buffer is read once, on first use. Private to scenes.
class GltfBuffers {
public:
    explicit GltfBuffers(const GltfDocument& document);

    /// The bytes of the buffer view of that number, valid as long as this object. Throws Error{bad_data} if some are
    /// missing.
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
    std::map<std::string, std::string> files_; ///< by name: several buffers may use one file
    std::uint64_t bytes_read_ = 0;
};

} // namespace oncollide
