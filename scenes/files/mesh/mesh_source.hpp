#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/reading_progress.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

// Shared by the readers of mesh files. Private to scenes.

/// A file in memory. The source's name begins every message.
struct MeshSource {
    std::string name;
    std::string_view bytes;

    /// Throws Error{bad_data}; `line` 0 stands for the file as a whole.
    [[noreturn]] void fail(const std::string& what, std::size_t line = 0) const;
};

/// The contents of a mesh file before make_mesh's checks: indices may be out of range.
struct RawMesh {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
};

// One reader per format. Readers are strict, and their allocations are bounded by the size of the file. In formats that
// repeat vertices for every triangle, equal positions become one vertex.
/// The objects (`o`) and the groups (`g`) of an OBJ file, in order. The triangles from `begin` up to the next section
/// of the same kind belong to a section. Sections without triangles may be missing.
struct ObjSections {
    struct Section {
        std::string name;
        std::size_t begin;
    };
    std::vector<Section> objects, groups;
};
RawMesh read_obj(const MeshSource& source);
RawMesh read_obj(const MeshSource& source, ObjSections& sections);
RawMesh read_off(const MeshSource& source);
RawMesh read_ply(const MeshSource& source);
RawMesh read_stl(const MeshSource& source);
/// The same for a file of at most `most` bytes; a binary file is never in memory as a whole.
RawMesh read_stl_file(const std::filesystem::path& path, std::uintmax_t most);
bool is_binary_stl(std::string_view bytes);
/// glTF and GLB: the triangles of the default scene (of all nodes if there is no scene), placed by its nodes and
/// welded. Separate buffer files are found beside the file at source.name. Instances of EXT_mesh_gpu_instancing and
/// morph targets at their default weights count; skins (with a warning), animations, points and lines are ignored. The
/// total of triangles, vertices and parts of meshes is limited to the bytes of all files, and to 200 million; but 10
/// million are always allowed.
RawMesh read_gltf(const MeshSource& source);
/// COLLADA: the triangles and polygons of the visual scene, in metres, z up. A controller counts as the mesh that it
/// deforms. 3MF: the objects that the build places, in metres. Both have the limits of glTF. Throw Error{usage} without
/// ONCOLLIDE_XML.
RawMesh read_collada(const MeshSource& source);
RawMesh read_3mf(const MeshSource& source);

/// A separator of words other than the end of a line.
inline bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// LF, or CR in a text that has no LF.
inline char end_of_lines(std::string_view text)
{
    return text.find('\n') == text.npos && text.find('\r') != text.npos ? '\r' : '\n';
}

/// Splits text into lines and lines into words; counts lines for messages. Lines end with LF or CR LF; in a file
/// without LF they end with CR, as on old Macs. A byte-order mark is skipped.
class TextReader {
public:
    explicit TextReader(const MeshSource& source)
        : source_(source), rest_(without_byte_order_mark(source.bytes)), line_end_(end_of_lines(rest_)),
          progress_(source.name, source.bytes.size())
    {
    }

    /// Goes to the next line that has a word; `#` starts a comment, and with `continued` a backslash at the end joins
    /// lines. False at the end of the file.
    bool next_line(bool continued = false);
    /// The next word of the line; empty at its end.
    std::string_view word();
    /// The next word as a number. Throws naming the line if there is none or it is not finite.
    double number(const char* what);
    std::int64_t whole_number(const char* what);
    Eigen::Vector3d point();
    std::size_t line() const { return line_; }
    /// The text after the line, for faster parsers of particular lines, and the amount that they consumed.
    std::string_view rest() const { return rest_; }
    void skip_lines(std::size_t bytes, std::size_t lines) { rest_.remove_prefix(bytes), line_ += lines; }
    /// Reports progress.
    void reached(const char* at) { progress_.at(static_cast<std::uint64_t>(at - source_.bytes.data())); }
    [[noreturn]] void fail(const std::string& what) const { source_.fail(what, line_); }

private:
    const MeshSource& source_;
    std::string_view rest_;
    const char line_end_;
    std::string_view words_;
    std::string joined_;
    std::size_t line_ = 0;
    ReadingProgress progress_;
};

/// A word shortened and made printable for a message.
std::string quoted(std::string_view word);

/// The whole word as a number; false for any other word. Outside double's range: infinite or zero, as by rounding.
bool parse(std::string_view word, double& value);
bool parse(std::string_view word, std::int64_t& value);

} // namespace oncollide
