#pragma once
#include <atomic>

#include <oncollide/base/threads/idle_objects.hpp>
#include <oncollide/pipeline/refine/gpu_pairs.hpp>
#include <oncollide/pipeline/refine/narrowing.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/frame_manifolds.hpp>
#include <oncollide/pipeline/world/motion_forecast.hpp>
#include <oncollide/pipeline/world/stage.hpp>
#include <oncollide/pipeline/world/sweep_pairs.hpp>

namespace oncollide {

/// The pairs of a query, checked.
struct PairTasks {
    std::vector<PairTask> tasks;
    std::vector<Eigen::Isometry3d> poses; ///< poses of pairs given as columns

    std::size_t size() const { return tasks.size(); }
    const PairTask& operator[](std::size_t i) const { return tasks[i]; }
};

/// The data of a World, which its views share. Implemented in world.cpp (checks of arguments), world_models.cpp,
/// world_bodies.cpp, world_step.cpp (frames), world_pairs.cpp, world_contacts.cpp, world_sweeps.cpp and
/// world_manifolds.cpp (Pairs), world_space.cpp and world_casts.cpp (Space).
struct ONCOLLIDE_LOCAL WorldImpl {
    Models models_view{*this};
    Bodies bodies_view{*this};
    Settings settings; ///< with `exact` resolved
    ExactLevel requested_exact = ExactLevel::automatic;
    const std::uint16_t tag; ///< in the ids that this World issues
    ModelStore models;
    BodyTable bodies;
    std::vector<std::uint32_t> users; ///< by model slot: number of bodies that use it
    std::unique_ptr<BroadPhase> broad;
    std::unique_ptr<GpuPairs> gpu; ///< decides pairs of meshes; null unless the backend is gl

    Frame frame;
    FrameManifoldCache frame_manifolds;
    bool changed_since_step = false; ///< bodies or models changed since the last frame
    SweepPairs sweeps{models};
    std::vector<std::unique_ptr<Stage>> stages;
    std::vector<std::uint8_t> skipped;            ///< by stage: skipped by request
    std::vector<StageStats> stats, totals, blank; ///< blank: initial values of a frame
    MotionForecast forecast;
    std::vector<PairOfBodies> began, ended;
    std::string backend_note;
    std::uint64_t hash = 0, frame_hash = 0; ///< hashes of all frames; of the last frame

    struct QueryWorker;                      // query_worker.hpp
    std::unique_ptr<QueryWorker> gpu_worker; ///< of the thread that owns the GPU
    WorldMutex guard;                        ///< guards the models' trees during const calls
    std::atomic<bool> taken_in{false};       ///< true if all changes are in the boxes and the broad phase
    /// For const calls: a model with its tree, until bodies or models change or a step ends. Spares a lock.
    std::atomic<const Model*> with_tree{nullptr};
    IdleObjects<QueryWorker, LockRank::query_workers> idle_workers;

    WorldImpl(const Settings& settings, std::unique_ptr<OcclusionBackend> backend, std::string note);
    ~WorldImpl();
    static std::unique_ptr<WorldImpl> make(const Settings& settings, std::unique_ptr<OcclusionBackend> backend,
                                           const MeshWalkOptions& gpu_options);

    // Checks of arguments. Each throws before anything changes.
    std::uint32_t slot_of(BodyId id) const;
    Model& model_of(ModelId id);
    static void check_pose(const char* whose, const Eigen::Isometry3d& pose);
    static void check_sweep(const char* call, const SweepOptions& options);
    static void check_pose(std::uint32_t slot, const Eigen::Isometry3d& pose);
    Model& check_model(ModelId id); ///< for a query: reads all of a cooked mesh if the settings need all
    /// Throws for an open mesh in solid mode, unless it is taken as a surface.
    void check_inside(const Model& model) const;
    void check_body(const BodySpec& body);
    static std::string label(std::uint32_t slot) { return "body " + std::to_string(slot); }

    BodyId add_checked(const BodySpec& body);
    void remove_checked(std::uint32_t slot);
    void replace(ModelId id, std::shared_ptr<const Geometry> geometry);
    const Mesh& check_vertices(ModelId id); ///< throws for a model whose vertices cannot move
    /// Moves vertices [first, first + positions.size()), which must exist.
    void set_vertices(ModelId id, std::size_t first, std::span<const Eigen::Vector3d> positions);
    /// Throws for a model whose heights cannot change, or a rectangle that is not part of it.
    void check_heights(ModelId id, const TerrainRectangle& where, std::size_t count);
    void set_heights(ModelId id, const TerrainRectangle& where, std::span<const double> heights);
    /// Calls visit(slot) for the bodies of a model.
    template <class Visit>
    void each_body(ModelId id, Visit visit);
    void changed()
    {
        changed_since_step = true;
        taken_in.store(false, std::memory_order_release);
        with_tree.store(nullptr, std::memory_order_relaxed);
    }

    bool runs(StageId stage) const;
    std::string note_on_backend() const;
    std::string name_of_backend() const { return gpu ? gpu->name() : models.backend().name(); }

    // Pairs of const queries.
    void check_side(const PairSide& side);                  ///< throws for an id or a pose that is refused
    PairTask task_of(const PairSide& a, const PairSide& b); ///< the task of two sides that were checked
    PairTask checked_task(const PairSide& a, const PairSide& b);
    PairTask task_of(const PairOfColumns& pairs, std::size_t first, std::size_t k, Eigen::Isometry3d* poses);
    template <class Pair>
    void check_pairs(std::span<const Pair> pairs);
    PairTasks ready_tasks(const char* call, const PairSpan& pairs);
    /// True if a body of the pair is in a cooked file and read on demand.
    bool reads_a_part(const PairTask& task) const
    {
        const auto on_demand = [&](const Model& model) { return model.cooked() && reads_on_demand(settings); };
        return on_demand(*task.a) || on_demand(*task.b);
    }
    /// Makes the trees that contacts and distances are found with, where a walk does not make them.
    void need_trees(std::span<const PairTask> tasks);
    void decide(QueryWorker& worker, std::span<Finding> found);
    /// Decides pairs on the GPU, many at a time. Returns false, and does nothing, if that does not pay or cannot be.
    template <class Form>
    bool decide_on_gpu(const Form& pairs, std::span<Finding> found);
    Distance distance(QueryWorker& worker, const PairTask& task, const DistanceOptions& options);
    /// The trees must be there.
    bool may_be_near(QueryWorker& worker, const PairTask& task, double reach);
    void contacts(QueryWorker& worker, const PairTask& task, std::vector<Contact>& found);
    Penetration penetration(QueryWorker& worker, const PairTask& task);
    /// The trees must be there.
    SweepResult sweep(QueryWorker& worker, const SweepTask& task);
    std::vector<SweepTask> ready_tasks(std::span<const PairOf<MovingModel>> pairs, const SweepOptions& options);
    SweepTask task_of(const MovingModel& a, const MovingModel& b, const SweepOptions& options);
    double find_casts(QueryWorker& worker, const MovingModel& model, const CollisionFilter& filter,
                      const SweepOptions& options, bool all, std::vector<SweepHit>& hits);
    SweepHit first_cast(QueryWorker& worker, const MovingModel& model, const CollisionFilter& filter,
                        const SweepOptions& options);
    /// Overwrites `found`. The trees must be there.
    void manifold(QueryWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& found);
    /// Calls take(i, StoredManifold), which may add it to the join, for each task, ascending; the manifolds are found
    /// on the World's threads.
    template <class Take>
    void manifolds(std::span<const PairTask> tasks, const ManifoldOptions& options, ManifoldJoin& join, Take take);
    void check_placed(const char* call, std::size_t number, const PlacedModel& placed);
    struct Probe; // a model at a pose against all bodies: world_space.cpp
    void find_near(QueryWorker& worker, const Probe& probe, double margin);
    void refine_hits(QueryWorker& worker, const Probe& probe, std::vector<QueryHit>& hits);
    void find_hits(QueryWorker& worker, const Probe& probe, std::vector<QueryHit>& hits);
    bool allows(const CollisionFilter& filter, std::uint32_t slot) const;
    bool has_tree_for_segments(std::uint32_t slot);
    bool tests_segments(std::uint32_t slot);
    void find_boxes(QueryWorker& worker, const Segment& segment);
    Finding on_segment(QueryWorker& worker, std::uint32_t slot, const Segment& segment);
    void find_hits(QueryWorker& worker, const Segment& segment, const CollisionFilter& filter,
                   std::vector<QueryHit>& hits);
    std::optional<CastHit> cast(QueryWorker& worker, std::uint32_t slot, const Segment& segment, double reach);
    void find_casts(QueryWorker& worker, const Segment& segment, const CollisionFilter& filter, bool all);
    CastHit first_cast(QueryWorker& worker, const Segment& segment, const CollisionFilter& filter);
    template <class Form>
    void take_tasks(QueryWorker& worker, const Form& pairs, std::size_t first, std::size_t many);
    template <class Form, class Work>
    void in_batches(const char* call, const Form& pairs, std::size_t room, Work work);
    /// Passes the changes to the broad phase and lists the AABBs to update.
    void take_in_changes();
    /// True if this frame must have the results of the last one, pair by pair.
    bool rests() const;
    void run_stages();
    void repeat_stages(); ///< the counts of the last frame, as nothing changed
    void find_events();
    void find_events(std::span<const PairResult> now, std::span<const PairResult> last);
    std::string validate() const; ///< the first fault; empty: none
    void look_ahead();
    /// For const calls: updates AABBs and broad phase if there are changes.
    void bring_up_to_date();

    class Lease;
    template <class Work>
    void each(std::size_t items, std::size_t chunk, Work work);
    template <class Found, class Work>
    void gather(std::size_t items, std::size_t chunk, Lists<Found>& lists, Work work);
};

/// "model 3 (generation 1)".
std::string text_of(const char* what, std::uint32_t slot, std::uint32_t generation);
/// Throws for a distance that near_features() does not take.
void check_dhat(double dhat);

} // namespace oncollide
