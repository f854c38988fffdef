#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

/// The steps of the work on the GPU, in order. The last three run once for each batch.
enum class MeshWalkStep : std::uint8_t { context, shaders, self_test, trees, upload, dispatch, readback };

struct MeshWalkOptions {
    int gpu = -1; ///< as for describe_gpu()
    /// Upper limit of the size of one buffer (bytes); 0: the driver's limit, at most 2 GiB.
    std::size_t most_buffer_bytes = 0;
    std::uint32_t worth_pairs = 64;      ///< the CPU decides fewer pairs sooner than a batch ends; for GpuRefiner
    std::uint32_t first_items = 1 << 16; ///< initial room of a queue; it grows after a batch that needed more
    // Tests set these two.
    std::function<void(MeshWalkStep)> before{};            ///< called before each step; it may throw GpuLost
    std::function<std::string(std::string)> edit_shader{}; ///< changes a shader, as a driver with a fault would
};

/// A rigid pose: the columns of its rotation, then its translation.
struct MeshWalkPose {
    double columns[12];

    explicit MeshWalkPose(const Eigen::Isometry3d& pose)
    {
        for (int i = 0; i < 12; ++i) columns[i] = pose.data()[i / 3 * 4 + i % 3];
    }
};

/// Two meshes at their poses. Computations are in a's frame, as in the CPU's decision of (a, b).
struct MeshWalkPair {
    static constexpr std::uint32_t no_hint = 0xffffffffu;
    std::uint32_t pose_a, pose_b;                     ///< numbers in the batch's poses
    std::uint32_t tree_a, tree_b;                     ///< as hold() returned them
    std::uint32_t hint_a = no_hint, hint_b = no_hint; ///< two triangles that are tested first
    /// Metres, rounded up: if triangles come this near without certainly meeting, the pair stays open.
    float enough = 0;
};

enum class MeshWalkVerdict : std::uint32_t {
    apart, ///< at least `bound` apart, and no two triangles are within the pair's `enough` (MeshWalks::submit)
    meets, ///< triangles a and b certainly meet
    /// MeshWalks::unsure() has pairs of triangles that may meet. All others are apart, by at least `bound`.
    unsure,
    open, ///< nothing is known: a box is not grown, triangles are within `enough`, or a queue was full
};

struct MeshWalkResult {
    MeshWalkVerdict verdict;
    float bound; ///< metres, a lower bound of the distance
    std::uint32_t a, b;
};

/// A pair of triangles that the filter leaves to exact arithmetic.
struct UnsureTriangles {
    std::uint32_t pair; ///< its number in the batch
    std::uint32_t a, b; ///< triangles
};

/// A box that a walk could not open, because the tree's copy has no node below it.
struct WantedNode {
    std::uint32_t tree, node, box;
};

/// The work of all batches so far.
struct MeshWalkCounts {
    std::uint64_t batches = 0, dispatches = 0;
    std::uint64_t pairs = 0;
    std::uint64_t box_rows = 0;                 ///< tests of one box against all boxes of a node
    std::uint64_t triangle_pairs = 0;           ///< tested by the filter
    std::uint64_t unsure_pairs = 0;             ///< of these, left to exact arithmetic
    std::uint64_t tree_bytes = 0;               ///< trees and triangles, up
    std::uint64_t bytes_up = 0, bytes_down = 0; ///< poses and pairs; results
    std::uint64_t trees_without_room = 0;
    std::uint64_t full = 0; ///< batches in which a queue or a list was full
    // Milliseconds by the GPU's clock.
    double upload_ms = 0, prepare_ms = 0, walk_ms = 0, readback_ms = 0;
    double wait_ms = 0; ///< the caller waited
    double gpu_ms() const { return upload_ms + prepare_ms + walk_ms + readback_ms; }
};

/// Decides pairs of meshes on a GPU: the trees' nodes and the triangles stay there, a batch brings poses and pairs, and
/// brings back a word or two for each pair. Verdicts are certain: boxes are compared with margins above the rounding of
/// any order of operations, and triangles by a filter in double. Calls belong to the thread that made it. Any call may
/// throw GpuLost; it is unusable then.
class MeshWalks {
public:
    virtual ~MeshWalks() = default;
    virtual const GpuInfo& info() const = 0;
    /// True on the thread that made it.
    virtual bool is_owner() const = 0;
    /// The number of the tree on the GPU, brought up to date; none: the tree is of a cooked or a deformed mesh, it is
    /// not grown below its root, its size is out of the range of floats, or there is no room.
    /// @param frame  the tree stays until drop_unused() is called with a later one
    virtual std::optional<std::uint32_t> hold(const ObbTree& tree, std::uint32_t frame) = 0;
    /// Drops the trees that were not held since this frame.
    virtual void drop_unused(std::uint32_t frame) = 0;
    /// Queues a batch: trees that changed, then poses and pairs. At most most_pairs.
    /// @param by_distance  true: triangles whose distance may be at most `enough` leave a pair open; false: triangles
    /// with two corners that are this near
    virtual void submit(std::span<const MeshWalkPose> poses, std::span<const MeshWalkPair> pairs, bool by_distance) = 0;
    /// Waits for the batch. The results are valid until the next submit().
    virtual std::span<const MeshWalkResult> collect() = 0;
    virtual std::span<const UnsureTriangles> unsure() const = 0; ///< of the batch, in any order
    virtual std::span<const WantedNode> wanted() const = 0;      ///< the same; nodes may come more than once
    virtual const MeshWalkCounts& counts() const = 0;
    virtual std::size_t bytes() const = 0; ///< memory of the GPU in use

    static constexpr std::size_t most_pairs = 1 << 16;
};

/// Throws Error{no_gpu} if there is no GPU with OpenGL 4.5, and GpuLost if its driver cannot compile the shaders or
/// fails the self-test: pairs whose verdicts are known.
std::unique_ptr<MeshWalks> make_mesh_walks(const MeshWalkOptions& options = {});

} // namespace oncollide
