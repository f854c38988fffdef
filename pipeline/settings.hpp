#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/base/error.hpp>

namespace oncollide {

class Executor;

/// Automatic: predicates, where they cost no more than a bound; see exact_level().
enum class ExactLevel : std::uint8_t { off, predicates, fcl, automatic };
enum class Mode : std::uint8_t { surface, solid };
enum class BackendKind : std::uint8_t {
    automatic, ///< gl_compute on a hardware GPU, otherwise cpu
    cpu,
    gl_compute, ///< on a GPU; the same results as cpu
    gl_query,   ///< the paper's occlusion queries, for comparison: **not certified**, misses collisions
    gl ///< decides pairs of meshes on a GPU by their OBB trees; the same results as cpu, which takes over where
       ///< there is no GPU
};
enum class BroadPhaseKind : std::uint8_t { kd_tree, octree, brute_force };

/// The stages of a frame, in order.
enum class StageId : std::uint8_t { bounds, delimitation, broad, refine, exact };
constexpr std::size_t stage_count = 5;

/// A set of stages.
class StageSet {
public:
    constexpr StageSet() = default;
    constexpr StageSet(std::initializer_list<StageId> stages)
    {
        for (const StageId stage : stages) insert(stage);
    }
    constexpr void insert(StageId stage) { bits_ |= static_cast<std::uint8_t>(1u << static_cast<unsigned>(stage)); }
    constexpr bool contains(StageId stage) const { return bits_ >> static_cast<unsigned>(stage) & 1; }
    constexpr bool empty() const { return bits_ == 0; }
    friend constexpr bool operator==(StageSet, StageSet) = default;

private:
    std::uint8_t bits_ = 0;
};

/// The bounding volume that refines pairs: spheres around octree cells, as in the paper, or OBBs around parts of the
/// surface, which separate pairs sooner. Automatic: spheres if `depth` is given or a GPU finds their cells, and
/// predicates do not decide; otherwise OBBs.
enum class BoundingVolume : std::uint8_t { automatic, sphere, obb };

/// How a World decides pairs, and how exactly. The defaults suit most scenes.
struct Settings {
    /// `max_error` and `depth` set the error; with either of them, results are bounded instead of exact. `max_error`
    /// (m, > 0): two bodies reported `within` are closer than clearance + max_error. `depth` (1 to 16) is the paper's
    /// dial: the depth of all sphere-trees. At most one of the two may be set. If neither is set and results are not
    /// exact, the error of a pair is default_error times the diagonal of its smaller box, so that on one terrain a
    /// pedestrian gets centimetres and an airship metres.
    std::optional<int> depth{};
    std::optional<double> max_error{};
    double clearance = 0; ///< metres, >= 0: pairs this close count as touching, in every stage

    ExactLevel exact = ExactLevel::automatic;
    /// Determine whether colliding pairs of meshes touch or cross. Predicates only.
    bool contact_kinds = false;
    /// Pairs of meshes that only touch are separate, with a bound of 0. It needs predicates, surface mode and clearance
    /// 0: solid bodies that only touch may still hold a part of each other.
    bool ignore_touching = false;
    Mode mode = Mode::surface;              ///< solid: a mesh's inside belongs to it; it must be closed
    bool open_as_surface = false;           ///< solid mode: take a mesh that is not closed as a surface
    BackendKind backend = BackendKind::cpu; ///< builds the sphere-trees of meshes; gl: decides pairs of meshes
    BoundingVolume bounding_volume = BoundingVolume::automatic;
    int gpu = -1;      ///< number in gpu_devices(); -1: the first device that is a GPU. GPU backends only
    int viewport = 16; ///< pixels per side that gl-query draws, 1 to 1024
    BroadPhaseKind broad_phase = BroadPhaseKind::kd_tree;
    int threads = 1;                 ///< 0: as many as the executor has. Never changes the result
    Executor* executor = nullptr;    ///< runs the parallel loops; null: threads of the library's own
    StageSet skip{};                 ///< stages to leave out; results get wider, never wrong
    int age_limit = 60;              ///< frames after which cells that no test reached are dropped; >= 1
    std::size_t node_budget = 0;     ///< cells that all trees together may hold; 0: no limit
    std::size_t memory_budget = 0;   ///< bytes that trees and triangle lists may hold; 0: no limit. A quarter of it, 1
                                     ///< to 16 MiB, bounds the walks that wait for trees to grow
    std::size_t resident_budget = 0; ///< bytes that chunks of cooked meshes may hold; 0: no limit. Dropped chunks
                                     ///< are read again; a pair that needs more at once stays `undecided`
    int look_ahead = 0; ///< frames for which another thread prefetches the cooked meshes that moving bodies approach;
                        ///< 0: no prefetch. Never changes the result
    bool coherence = true; ///< first test the parts that decided a pair last, and skip pairs that cannot have met
                           ///< since. Never changes the result; without it, every pair is traversed
    /// Called every few pairs, by any thread of the call. Once it returns true, pairs that are not refined yet stay
    /// `undecided`, so that step(), query() and decide() end soon. The next call is not affected.
    std::function<bool()> stop{};
};

/// A pair's error by default, as a share of the diagonal of the smaller body's box (in its own frame).
constexpr double default_error = 0.01;

/// True for a backend that may build sphere-trees on a GPU.
constexpr bool makes_spheres_on_gpu(BackendKind backend)
{
    return backend != BackendKind::cpu && backend != BackendKind::gl;
}

/// The exact level that `settings` stand for. Automatic is off if an error, a clearance, spheres, spheres on a
/// GPU or a memory budget is requested, and otherwise predicates.
inline ExactLevel exact_level(const Settings& s)
{
    if (s.exact != ExactLevel::automatic) return s.exact;
    const bool bounded = s.depth || s.max_error || s.clearance > 0 || s.bounding_volume == BoundingVolume::sphere ||
                         makes_spheres_on_gpu(s.backend) || s.memory_budget > 0;
    return bounded ? ExactLevel::off : ExactLevel::predicates;
}

/// The number of threads that `settings` stand for; >= 1.
ONCOLLIDE_API int thread_count(const Settings& settings);

/// Throws Error{usage} naming the setting, its value and the valid range.
ONCOLLIDE_API void check(const Settings& settings);

// Names as on the command line. from_name throws Error{usage} that lists the valid names.
ONCOLLIDE_API std::string_view name_of(ExactLevel);
ONCOLLIDE_API std::string_view name_of(Mode);
ONCOLLIDE_API std::string_view name_of(BackendKind);
ONCOLLIDE_API std::string_view name_of(BroadPhaseKind);
ONCOLLIDE_API std::string_view name_of(BoundingVolume);
ONCOLLIDE_API std::string_view name_of(StageId);
ONCOLLIDE_API ExactLevel exact_from_name(std::string_view);
ONCOLLIDE_API Mode mode_from_name(std::string_view);
ONCOLLIDE_API BackendKind backend_from_name(std::string_view);
ONCOLLIDE_API BroadPhaseKind broad_phase_from_name(std::string_view);
ONCOLLIDE_API BoundingVolume bounding_volume_from_name(std::string_view);
ONCOLLIDE_API std::span<const std::string_view> all_stage_names(); ///< in order
/// The stages of these names, or the names of these stages in order.
ONCOLLIDE_API StageSet stages_from_names(std::span<const std::string> names);
ONCOLLIDE_API std::vector<std::string> names_of(StageSet stages);
ONCOLLIDE_API StageId stage_from_name(std::string_view);

} // namespace oncollide
