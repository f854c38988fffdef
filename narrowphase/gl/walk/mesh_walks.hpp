#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

/// The steps of the work on the GPU, in order. The last four run once for each batch.
enum class MeshWalkStep : std::uint8_t { context, doubles, shaders, self_test, trees, upload, dispatch, readback };

class MeshWalks;

struct MeshWalkOptions {
    int gpu = -1; ///< as for describe_gpu()
    /// Upper limit of the size of one buffer (bytes); 0: the driver's limit, at most 2 GiB.
    std::size_t most_buffer_bytes = 0;
    std::uint32_t worth_pairs = 64;      ///< the CPU decides fewer pairs sooner than a batch ends; for GpuRefiner
    std::uint32_t first_items = 1 << 16; ///< initial room of a queue; it grows after a batch that needed more
    // Tests set these.
    std::function<void(MeshWalkStep)> before{};            ///< called before each step; it may throw GpuLost
    std::function<std::string(std::string)> edit_shader{}; ///< changes a shader, as a driver with a fault would
    std::string hidden_extension{};                        ///< counts as missing
    std::function<std::unique_ptr<MeshWalks>()> make{};    ///< replaces make_mesh_walks(), for GpuPairs
};

/// Two meshes at their relative pose, as the GPU reads them.
struct MeshWalkPair {
    static constexpr std::uint32_t no_hint = 0xffffffffu;
    double rotation[9];                               ///< columns; of RelativePose, from b's frame into a's
    double translation[3];                            ///< of RelativePose
    std::uint32_t tree_a, tree_b;                     ///< as hold() returned them
    std::uint32_t hint_a = no_hint, hint_b = no_hint; ///< two triangles that are tested first
    /// Metres, rounded up: if triangles come this near without certainly meeting, the pair stays open.
    float enough = 0;
    std::uint32_t unused[3]{};

    MeshWalkPair(const RelativePose& b_to_a, std::uint32_t a, std::uint32_t b) : tree_a(a), tree_b(b)
    {
        for (int i = 0; i < 9; ++i) rotation[i] = b_to_a.rotation.data()[i]; // faster than a call of memmove()
        for (int i = 0; i < 3; ++i) translation[i] = b_to_a.translation[i];
    }
};
static_assert(sizeof(MeshWalkPair) == 128);

enum class MeshWalkVerdict : std::uint32_t {
    apart, ///< at least `bound` apart, and no two triangles are within the pair's `enough` (MeshWalks::submit)
    meets, ///< triangles a and b certainly meet
    /// MeshWalks::unsure() has pairs of triangles that may meet. All others are apart, by at least `bound`.
    unsure,
    /// Nothing is known: a box is not grown, triangles are within `enough`, a queue was full, or the walk found many
    /// triangles that may meet (MeshWalks::unsure()) and ended.
    open,
};

/// The result of a pair, as the GPU writes it.
struct MeshWalkResult {
    /// Bits of the state. The rest of the word counts the pair's items that no team has ended yet. If a driver ends a
    /// shader too soon (llvmpipe ends loops after 65,535 passes), this count stays above 0, and the pair is open.
    static constexpr std::uint32_t state_met = 1, state_open = 2, state_unsure = 4, state_item = 256;
    std::uint32_t state;
    float bound; ///< metres, a lower bound of the distance
    std::uint32_t a, b;

    MeshWalkVerdict verdict() const
    {
        return state & state_met                               ? MeshWalkVerdict::meets
               : state & state_open || state / state_item != 0 ? MeshWalkVerdict::open
               : state & state_unsure                          ? MeshWalkVerdict::unsure
                                                               : MeshWalkVerdict::apart;
    }
};
static_assert(sizeof(MeshWalkResult) == 16);

/// A pair of triangles that the filter leaves to exact arithmetic.
struct UnsureTriangles {
    std::uint32_t pair; ///< its number in the batch
    std::uint32_t a, b; ///< triangles
};

/// A box that a walk could not open, because the tree's copy has no node below it.
struct WantedNode {
    std::uint32_t tree, node, box;
};

/// The work of batches.
struct MeshWalkCounts {
    std::uint64_t batches = 0, dispatches = 0;
    std::uint64_t pairs = 0;
    std::uint64_t box_rows = 0;                 ///< tests of one box against all boxes of a node
    std::uint64_t triangle_pairs = 0;           ///< tested by the filter
    std::uint64_t unsure_pairs = 0;             ///< of these, left to exact arithmetic
    std::uint64_t tree_bytes = 0;               ///< trees and triangles, up
    std::uint64_t bytes_up = 0, bytes_down = 0; ///< pairs with their poses; results
    std::uint64_t trees_without_room = 0;       ///< now
    std::uint64_t full = 0;                     ///< batches in which a queue or a list was full
    // Milliseconds by the GPU's clock.
    double upload_ms = 0, prepare_ms = 0, walk_ms = 0, readback_ms = 0;
    double wait_ms = 0; ///< the caller waited
    double gpu_ms() const { return upload_ms + prepare_ms + walk_ms + readback_ms; }
    /// Adds the work of another batch.
    MeshWalkCounts& operator+=(const MeshWalkCounts& batch)
    {
        batches += batch.batches, dispatches += batch.dispatches, pairs += batch.pairs, box_rows += batch.box_rows;
        triangle_pairs += batch.triangle_pairs, unsure_pairs += batch.unsure_pairs, tree_bytes += batch.tree_bytes;
        bytes_up += batch.bytes_up, bytes_down += batch.bytes_down, full += batch.full;
        upload_ms += batch.upload_ms, prepare_ms += batch.prepare_ms, walk_ms += batch.walk_ms;
        readback_ms += batch.readback_ms, wait_ms += batch.wait_ms;
        return *this;
    }
};

/// Decides pairs of meshes on a GPU: the trees' nodes and the triangles stay there, a batch brings pairs with their
/// poses, and brings back four words for each pair. Verdicts are certain: boxes are compared with margins above the
/// rounding of any order of operations, and triangles by a filter in double. Calls belong to the thread that made it.
/// Any call may throw GpuLost; it is unusable then.
///
/// A batch is begin(), submit(), collect(). The next one may begin before the last one is collected, so that the CPU
/// fills one while the GPU decides the other.
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
    /// Room for the pairs of a batch, 1 to most_pairs, in memory that the GPU reads. Any threads may write it, each
    /// pair once and whole; reading it is slow. At most most_batches may have begun and not been collected.
    virtual std::span<MeshWalkPair> begin(std::size_t pairs) = 0;
    /// Queues the batch that began: trees that changed, then the pairs.
    /// @param by_distance  true: triangles whose distance may be at most `enough` leave a pair open; false: triangles
    /// with two corners that are this near
    virtual void submit(bool by_distance) = 0;
    /// Waits for the first batch that was not collected yet. The results are valid until the next submit(); any thread
    /// may read them.
    virtual std::span<const MeshWalkResult> collect() = 0;
    // The following describe the batch that was collected last.
    virtual std::span<const UnsureTriangles> unsure() const = 0; ///< in any order
    virtual std::span<const WantedNode> wanted() const = 0;      ///< the same; nodes may come more than once
    virtual const MeshWalkCounts& batch() const = 0;
    /// The sum of all batches so far.
    virtual const MeshWalkCounts& counts() const = 0;
    virtual std::size_t bytes() const = 0; ///< memory of the GPU in use

    static constexpr std::size_t most_pairs = 1 << 16;
    static constexpr std::size_t most_batches = 2;
};

/// Throws Error{no_gpu} if there is no GPU with OpenGL 4.3 (gl/context.hpp), and GpuLost if its driver has no doubles,
/// cannot compile the shaders or fails the self-test: pairs whose verdicts are known.
std::unique_ptr<MeshWalks> make_mesh_walks(const MeshWalkOptions& options = {});

} // namespace oncollide
