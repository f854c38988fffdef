#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/bodies.hpp>
#include <oncollide/pipeline/models.hpp>
#include <oncollide/pipeline/pairs.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/pipeline/space.hpp>

namespace oncollide {

/// The library's version, as in results; a test checks that it is the one in CMakeLists.txt.
inline constexpr std::string_view version = "0.1.0";

/// A candidate of a frame: two bodies that may collide, and whose AABBs are at most the clearance apart (unless the
/// broad phase is skipped).
struct CandidatePair {
    BodyId a, b;       ///< a.slot < b.slot
    Aabb box_a, box_b; ///< in the world, without the clearance
};

/// The choice of a filter for one candidate.
enum class PairChoice : std::uint8_t {
    refine,
    refine_swapped, ///< refine as the pair (b, a), which has this order in the results; the last bits of a bound may
                    ///< depend on it
    drop,           ///< the pair is not in the results
};

/// Sets choices[i] for pairs[i]; each is `refine` before the call. A frame calls it for runs of at most 1,024
/// candidates, in the order of their slots. It may call const members of the World that return data of bodies, and no
/// others. It must not throw.
using PairFilter = std::function<void(std::span<const CandidatePair> pairs, std::span<PairChoice> choices)>;

/// A copy of the state and the counts of a World.
struct WorldInfo {
    std::size_t bodies = 0, models = 0;
    std::uint64_t frames = 0;       ///< steps so far
    std::size_t bytes = 0;          ///< held for bodies, boxes, trees and joined faces; geometries are not counted
    std::string backend;            ///< finds grey cells, e.g. "cpu (avx2)"; or gl, which decides pairs
    std::string renderer;           ///< GL_RENDERER of a GPU backend; empty otherwise
    std::string backend_note;       ///< why the backend is not the expected one; empty: it is
    std::vector<StageStats> totals; ///< sums over all frames, per stage
    std::vector<DelimitedRegion> regions; ///< regions that the last frame's delimitation examined, level by level;
                                          ///< empty if it was skipped, or if a query has applied later changes
    std::vector<std::string> file_faults; ///< one line per chunk of a cooked file that could not be read; pairs that
                                          ///< needed it are `undecided`
};

/// Bodies and their models, which come, go, move and change between frames; a World finds which of them collide.
///
///     World world({.max_error = 0.01});
///     const ModelId hill = world.models().add(load_mesh("hill.obj"));
///     const ModelId truck = world.models().add(load_mesh("truck.glb"));
///     world.bodies().add({.model = hill, .is_static = true});
///     const BodyId mine = world.bodies().add({.model = truck, .pose = start});
///     while (...) {
///         world.bodies().set_pose(mine, next);
///         for (const PairResult& pair : world.step().pairs) ...
///     }
///
/// The cost of a frame follows the bodies that changed and the pairs they are in; a pair at rest costs a copy of its
/// result. Nothing is precomputed: trees grow where collisions reach. A warm step without additions allocates nothing.
///
/// Ids that are null, stale or of another World are errors. Errors are thrown at the call that brings them in, and then
/// nothing has changed: Error{usage} for such ids and for spans of different lengths, Error{bad_data} for poses that
/// are not rigid (R^T R off the identity by more than 1e-6, or a mirror), not finite or beyond 1e15 m, and for invalid
/// geometry. Every call on a World that was moved from throws Error{usage}, except destruction and assignment.
///
/// Const calls may run on many threads at once as long as no other call does. A World with a GPU backend belongs to the
/// thread that made it; with gl other threads may call it, too, and the CPU then decides.
class ONCOLLIDE_API World {
public:
    /// Throws Error{usage} for settings out of range, Error{no_gpu} for a backend that cannot run here.
    explicit World(const Settings& settings = {});
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    // The models and bodies that the World holds. References stay valid when the World is moved.
    Models& models();
    const Models& models() const;
    Bodies& bodies();
    const Bodies& bodies() const;

    Pairs pairs() const; ///< queries of two bodies or models: verdict, distance, contacts, sweeps
    Space space() const; ///< queries of one thing against all bodies: overlaps, casts, distances

    /// Reports all pairs as the bodies are now. Throws Error{no_gpu} if a GPU backend that was requested by name was
    /// lost in the frame before. That frame is complete: the CPU finished it. The CPU takes over with the backends
    /// `auto` and `gl`.
    FrameView step();
    /// Returns the manifolds of the last frame's pairs that meet or are at most the margin apart. A solver needs no
    /// other call after step(). Valid until the next step() or manifolds(). Pairs whose bodies did not change since the
    /// frame before are copied; if nothing changed, this costs nothing. Pairs::manifold() gives the same results. A
    /// warm call allocates nothing for shapes. With a margin, set Settings::clearance to at least as much: only
    /// candidates of the frame are looked at. Throws Error{usage} before the first step, if bodies or models changed
    /// since the last one, and for options out of range.
    const FrameManifolds& manifolds(const ManifoldOptions& options = {});
    /// Chooses which candidate pairs step() refines, where layers, groups and exclusions do not suffice; empty: all.
    /// Queries ignore it. Results are deterministic if the choice depends on the pair alone, not on the run that holds
    /// it. A pair that is dropped or swapped from some frame on ends in that frame. Cost: the calls, and about 0.1
    /// microseconds per candidate.
    void set_pair_filter(PairFilter filter);
    const PairFilter& pair_filter() const;
    /// How closely step() brackets contacts of moving bodies. Throws Error{usage} for tolerances below 1e-12.
    void set_sweep_options(const SweepOptions& options);
    const SweepOptions& sweep_options() const;

    const Settings& settings() const; ///< with `exact` resolved, see exact_level()
    /// Chained hash of all frames so far: equal input gives an equal hash for any thread count and instruction set.
    std::uint64_t hash() const;
    /// The rest of the World's state and counts. Cost: proportional to the size of the copies.
    WorldInfo inspect() const;

private:
    friend struct WorldAccess; // for the library's own layers, tools and tests; not installed
    explicit World(std::unique_ptr<WorldImpl> impl);
    WorldImpl& impl() const;
    std::unique_ptr<WorldImpl> impl_;
};

} // namespace oncollide
