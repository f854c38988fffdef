#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// One candidate pair at the end of a frame.
struct PairResult {
    BodyId a, b; ///< a < b
    Verdict verdict;
    std::uint8_t stage; ///< index into Pipeline::stages() of the stage that decided
    ContactKind kind;   ///< touching and crossing: where Settings::contact_kinds or ignore_touching asks
    double bound;       ///< separate: certified lower bound on the distance; within, undecided: certified upper bound;
                        ///< colliding: 0
};

/// Counts of one stage. Summed over frames by Pipeline::totals().
struct StageStats {
    std::string_view stage;
    std::string_view unit; ///< what is counted: "bodies" or "pairs"
    std::uint64_t frames = 0;
    std::uint64_t in = 0, out = 0, culled = 0, undecided = 0;
    double cpu_ms = 0;     ///< wall time, waiting included
    double gpu_ms = 0;     ///< time of the GPU's own clock
    double wait_ms = 0;    ///< part of cpu_ms in which the CPU did nothing but wait for the GPU
    bool skipped = false;  ///< left out, by request or because it could not pay for itself
    std::string_view note; ///< why it was skipped; empty otherwise
};

/// What the sphere-trees did in one frame.
struct TreeStats {
    std::uint64_t rounds = 0;         ///< batches asked of the backend
    std::uint64_t rows = 0;           ///< cells asked, all rounds
    std::uint64_t node_pairs = 0;     ///< pairs of cells, or of boxes, whose parts were compared
    std::uint64_t triangle_pairs = 0; ///< pairs of triangles tested by predicates
    std::uint64_t unsure_pairs = 0;   ///< of these, left by the filter to exact arithmetic
    std::uint64_t nodes = 0;          ///< cells and boxes' nodes stored at the end of the frame, roots included
    std::uint64_t collapsed = 0;      ///< cells dropped by ageing or eviction
    std::uint64_t refused = 0;        ///< cells that a budget kept from being asked
    std::uint64_t queries = 0;        ///< occlusion queries (gl-query)
    std::uint64_t gpu_bytes = 0;      ///< to the GPU and back
    std::uint64_t repeats = 0;        ///< batches done again with larger buffers
    std::size_t bytes = 0;            ///< nodes and triangle lists, float copies of the surfaces
};

/// One batch of cells asked of the backend. Times are milliseconds since the frame began.
struct Round {
    double submitted_ms = 0; ///< handed over
    double waited_ms = 0;    ///< the CPU had no other walks left, and waited
    double done_ms = 0;      ///< answered, trees grown
    std::uint64_t rows = 0;  ///< cells
    BatchWork work{};
};

/// The answer of one frame. Valid until the next step.
struct FrameView {
    std::uint64_t frame; ///< counted from 0 by the pipeline
    double ms;           ///< wall time of the frame, all stages
    std::span<const PairResult>
        pairs; ///< every pair that the broad phase kept, sorted by (a, b), separate ones included
    std::span<const StageStats> stages;              ///< of this frame, in order
    std::span<const DelimitationLevel> delimitation; ///< per level of the region hierarchy
    const TreeStats& trees;
    std::span<const Round> rounds; ///< in order
    std::uint64_t hash; ///< of the pairs of this frame that are not separate: names' indices, verdicts and bounds, and
                        ///< kinds where asked for
};

class Ocst;
class Stage;
struct Frame;

/// The whole pipeline for one scene's bodies: poses in, verdicts out, frame by frame.
///
///     Pipeline pipeline(scene, {.depth = 6});
///     for (...) { scene.poses[i] = ...; for (const PairResult& pair : pipeline.step(scene).pairs) ... }
///
/// The set of bodies and their geometry is fixed at construction; poses are read from `scene.poses` at each step.
/// Nothing is precomputed: trees grow where collisions reach. A warm step allocates nothing.
class Pipeline {
public:
    /// Throws Error{usage} for settings out of range, Error{no_gpu} for a backend that cannot run here,
    /// Error{bad_data} naming a mesh that is not closed and its open edges in solid mode.
    /// Keeps a reference to the geometries: `scene` must outlive the pipeline.
    /// @param backend  one of your own, in place of settings.backend
    /// With a GPU backend the pipeline belongs to the thread that made it.
    Pipeline(const Scene& scene, const Settings& settings = {}, std::unique_ptr<OcclusionBackend> backend = nullptr);
    ~Pipeline();
    Pipeline(Pipeline&&) noexcept;

    /// One frame. Throws, before any work, Error{bad_data} naming the body if a pose is not finite or not rigid, and
    /// Error{no_gpu} if a GPU backend that was asked for by name was lost in the frame before. That frame is whole: the
    /// CPU finished it. Under `auto` it goes on.
    FrameView step(const Scene& scene);

    /// Stage names in order: bounds, delimitation, broad, ocst, exact.
    std::span<const std::string_view> stages() const;
    /// Puts `stage` in the place of the stage of the same name. Throws Error{usage} for an unknown name.
    void replace(std::unique_ptr<Stage> stage);
    /// Sums over all frames so far.
    std::span<const StageStats> totals() const;
    /// Chained hash of all frames so far: equal input gives equal hash for any thread count and instruction set.
    std::uint64_t hash() const;
    /// The backend that answers, e.g. "cpu (avx2)".
    std::string backend() const;
    /// GL_RENDERER of a GPU backend; empty otherwise.
    std::string renderer() const;
    /// Under `auto`, why the CPU answers; or why a GPU stopped answering. Empty: nothing to say.
    std::string backend_note() const;
    const Settings& settings() const;
    /// The sphere-tree of a geometry as it is now, to look at: Ocst::for_each_cell(). Null until a test reaches it.
    /// Valid until the next step.
    const Ocst* tree(GeometryId geometry) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
