// Parts of a World that no installed header can name: for the library's own layers, tools and tests.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/stage.hpp>

namespace oncollide {

struct GpuHostTimes;
struct MeshWalkCounts;
struct MeshWalkOptions;

struct WorldAccess {
    class PlacedTests; // placed_tests.hpp

    /// A World with this backend in place of settings.backend.
    static World make(const Settings& settings, std::unique_ptr<OcclusionBackend> backend);
    /// A World with these options for the backend gl, except their `gpu`.
    static World make(const Settings& settings, const MeshWalkOptions& gpu_options);
    /// The work of the backend gl so far; all 0 with another backend.
    static MeshWalkCounts gpu_counts(const World& world);
    static GpuHostTimes gpu_host_times(const World& world);
    // As in WorldInfo, without the cost of the rest. Do not call it while queries run.
    static std::string backend(const World& world);
    static std::string renderer(const World& world);
    static std::string backend_note(const World& world);
    /// Puts another stage, which may call the old one, in the place of a stage. Call it before the first step.
    static void replace(World& world, StageId stage,
                        const std::function<std::unique_ptr<Stage>(std::unique_ptr<Stage> old)>& make);
    /// Lets sphere-trees grow ahead of the traversals.
    static void grow_ahead(World& world, bool on);
    /// Lets sweeps report parts that depend on the poses alone, not on the parts that met in earlier frames: for files
    /// that are equal wherever a run begins. Costs a decision for each contact at time 0.
    static void parts_by_poses(World& world);
    /// The sphere-tree of a model as it is now. Null until a test reaches it. Valid until the next step.
    static const Ocst* tree(const World& world, ModelId model);
    /// Makes the next step frame `frame`. `hash` is the hash of the frames before it, which another World stepped.
    static void continue_from(World& world, std::uint32_t frame, std::uint64_t hash);
    // The AABB that step() computes for a body of this model, at rest or on its way: the same bits in every World.
    static Aabb step_bounds(World& world, ModelId model, const Eigen::Isometry3d& pose);
    static Aabb step_bounds(World& world, ModelId model, const RigidMotion& motion);
    /// Sets near[i] to 0 for models that are certainly farther apart than the clearance and reaches[i] (m, >= 0), as
    /// bounding boxes show, and to 1 for others. Costs much less than distances. Surfaces alone count for meshes.
    static void near(const World& world, std::span<const PairOfModels> pairs, std::span<const double> reaches,
                     std::span<std::uint8_t> near);
    /// Sets until[i] to a lower bound of the time at which the models come within margins[i] (m, >= 0) more than the
    /// clearance of each other, if they are farther apart at time 0; 1: not before the end. Cost: one step of
    /// Pairs::sweep().
    static void clear_until(const World& world, std::span<const PairOf<MovingModel>> pairs,
                            std::span<const double> margins, std::span<double> until);
    /// Throws as Bodies::add() for a model, or the geometry of a future model, that has no inside although the settings
    /// require one.
    static void check_inside(const World& world, const std::shared_ptr<const Geometry>& geometry);
    static void check_inside(const World& world, ModelId model);
    /// Why Worlds refuse a pose; empty: they accept it.
    static std::string why_refused(const Eigen::Isometry3d& pose);
};

} // namespace oncollide
