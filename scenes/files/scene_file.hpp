#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

// Files of many bodies: scenes, and assemblies of meshes.

class Generators;

/// How a scene reads its geometries.
struct SceneReading {
    bool on_demand = false; ///< meshes in cooked files stay there, and are read in parts as tests need them
    /// The cooked file to use instead of a mesh file; the mesh file may be missing; empty: the mesh file is read.
    std::function<std::optional<std::filesystem::path>(const std::filesystem::path&, const MeshOptions&)> cooked{};
    /// Makes generated geometries, such as sample_generators() of oncollide::samples; null: they are refused.
    const Generators* generators = nullptr;
};

/// The format of scene files that load_scene reads and save_scene writes (docs/stability.md).
constexpr std::string_view scene_schema = "oncollide.scene";
constexpr int scene_schema_version = 1;

/// Reads a scene file (JSON; schema in docs/scene-format.md). Paths in it are relative to the file's own folder. "-" is
/// standard input, whose folder is the current one. Throws Error{no_input} or Error{bad_data}; messages begin with the
/// path and the place in it (`bodies[3].mesh`), and for an unknown key or name list the valid ones.
ONCOLLIDE_API Scene load_scene(const std::filesystem::path& path, const SceneReading& reading = {});
/// The same for a scene too large to store: hands its bodies to `sink` and returns the rest. Names of bodies may be
/// equal. If "exclude" names bodies instead of numbering them, the scene is stored during reading.
ONCOLLIDE_API SceneInfo load_scene(const std::filesystem::path& path, BodySink& sink, const SceneReading& reading = {});

/// Writes `scene` with its poses at frame 0 (start_poses), so that load_scene restores it bit for bit: every number is
/// written in a form that reads back exactly. Paths of files that the scene uses are relative to `path`'s folder.
/// Geometries made in code without a recipe are written into the scene file (meshes) or beside it as `.bt` files
/// (maps). Temporary name, then renamed. Throws Error{cannot_write}.
ONCOLLIDE_API void save_scene(const Scene& scene, const std::filesystem::path& path);

// --- Recorded vertices of a mesh that deforms: frames x vertices x (x, y, z), in its frame, metres.

/// The vertices in a `.npy` file or in a dataset of an HDF5 file, for SceneInfo::deform(). They are read while they are
/// played: as they are at the last whole frame, and after the last frame as there. Throws Error{no_input},
/// Error{bad_data}, and Error{usage} for a kind of file that this build cannot read.
ONCOLLIDE_API std::shared_ptr<Deformation> open_vertices(const std::filesystem::path& path,
                                                         const std::string& dataset = "vertices");

/// Writes such a file (HDF5, doubles, dataset "vertices") frame by frame.
///
///     VertexFile file("cloth.h5");
///     while (simulating) file.add(solver.positions());
///     file.close();
class ONCOLLIDE_API VertexFile {
public:
    /// Throws Error{cannot_write}, and Error{usage} if the build or the machine has no HDF5.
    explicit VertexFile(const std::filesystem::path& path);
    /// Removes the file unless it was closed.
    ~VertexFile();
    VertexFile(const VertexFile&) = delete;
    VertexFile& operator=(const VertexFile&) = delete;

    /// Appends a frame. Throws Error{usage} for no positions, or another number than in the first frame, and
    /// Error{cannot_write}.
    void add(std::span<const Eigen::Vector3d> positions);
    /// The file appears under its name; no frame can be added afterwards. Throws Error{cannot_write}, also for a file
    /// without a frame.
    void close();

private:
    struct ONCOLLIDE_LOCAL Open; ///< the file, while it is open
    [[noreturn]] void fail();

    std::string name_;
    std::unique_ptr<Open> open_;
    std::uint64_t frames_ = 0, vertices_ = 0;
};

// --- Assemblies.

/// A mesh at a pose. Parts of an assembly may have equal names.
struct AssemblyPart {
    std::string name;    ///< the name of its node, else of its mesh, else "node 17"; for other files the file name
                         ///< without extension. A name longer than 200 bytes loses its middle
    std::string path;    ///< the names of its ancestors and its own, separated by '/': the nearest 63 (7 in a file of
                         ///< more than 100,000 parts), and fewer beyond 1,000 bytes
    std::uint32_t above; ///< the number of its parent node; no_node_above: it has no parent
    std::size_t mesh;    ///< in Assembly::meshes
    Eigen::Isometry3d pose;
    std::string extras{}; ///< glTF: the JSON text of the node's "extras"; empty if there are none, or, with a warning,
                          ///< if it has more than 4,000 bytes
};
constexpr std::uint32_t no_node_above = 0xffffffffu;

/// The contents of a file, part by part. Parts that are copies of each other share a mesh.
struct Assembly {
    std::vector<std::shared_ptr<const Geometry>> meshes;
    std::vector<AssemblyPart> parts;
};

/// Whether the file name means an assembly: glTF, GLB, COLLADA (.dae), 3MF, and the formats of convert_files().
ONCOLLIDE_API bool is_assembly_file(const std::filesystem::path& path);

/// How load_assembly reads a file.
struct AssemblyOptions {
    double scale = 1; ///< metres per unit of the file; finite, > 0
    int threads = 1;
    bool objects = false; ///< an OBJ file is divided into its objects (`o`), or without any into its groups (`g`)
    /// Instances of instances can make 2^n parts with n lines: a file may have this many parts, or as many as it writes
    /// one by one.
    std::size_t most_parts = 100'000;
};

/// Reads a mesh file as an assembly: each node of a glTF, COLLADA or converted file, and each object that a 3MF file's
/// build places, is a part if it has triangles, at its pose in the scene; any other file is one part. Throws as
/// load_mesh, and Error{bad_data} for a file of more parts than options.most_parts and than it writes.
ONCOLLIDE_API Assembly load_assembly(const std::filesystem::path& path, const AssemblyOptions& options = {});

/// The same as a scene of one frame: a dynamic body for each part. Parts with equal names get a number appended.
ONCOLLIDE_API Scene load_assembly_scene(const std::filesystem::path& path, const AssemblyOptions& options = {});

} // namespace oncollide
