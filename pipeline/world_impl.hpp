#pragma once
#include <atomic>
#include <mutex>
#include <shared_mutex>

#include <oncollide/pipeline/refine/narrowing.hpp>
#include <oncollide/pipeline/refine/pair_distance.hpp>
#include <oncollide/pipeline/refine/penetration_depth.hpp>
#include <oncollide/pipeline/refine/non_mesh_contacts.hpp>
#include <oncollide/pipeline/stage.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide {

/// The data of a World. Implemented in world.cpp (models and bodies), world_step.cpp (frames) and world_queries.cpp
/// (const queries).
struct World::Impl {
    Settings settings;
    ModelStore models;
    Bodies bodies;
    std::vector<std::uint32_t> users; ///< by model slot: number of bodies that use it
    std::unique_ptr<BroadPhase> broad;

    Frame frame;
    std::vector<std::unique_ptr<Stage>> stages;
    std::vector<std::uint8_t> skipped;            ///< by stage: skipped by request
    std::vector<StageStats> stats, totals, blank; ///< blank: initial values of a frame
    MotionForecast courses;
    std::vector<PairOfBodies> active, last_active, began, ended; ///< active: not separate in the last frame
    std::string backend_note;
    std::uint64_t hash = 0;

    /// Working memory of one query thread.
    struct QueryWorker {
        explicit QueryWorker(Impl& impl);
        BothLevels levels;
        RefineContext context;
        ContactFinding contacts;
        NonMeshContacts solid_contacts;
        PairDistance distances;
        PenetrationDepth penetration;
        std::vector<Contact> meetings;
        std::vector<Aabb> boxes;
        std::vector<BoxHit> hits;
        std::vector<PairTask> tasks;
        std::vector<RefineResult> refined;
    };
    std::shared_mutex guard;           ///< for const calls: guards the models' trees
    std::mutex idle_guard;             ///< guards idle_workers
    std::atomic<bool> taken_in{false}; ///< true if boxes and broad phase include all changes
    std::vector<std::unique_ptr<QueryWorker>> idle_workers;

    Impl(const Settings& settings, std::unique_ptr<OcclusionBackend> backend, std::string note);

    // Checks of arguments. Each throws before anything changes.
    std::uint32_t slot_of(BodyId id) const;
    Model& model_of(ModelId id);
    void check_pose(std::optional<std::uint32_t> slot, const Eigen::Isometry3d& pose) const; ///< no slot: a new body
    void check_body(const BodySpec& body);
    std::string label(std::uint32_t slot) const { return "body " + std::to_string(slot); }

    BodyId add_checked(const BodySpec& body);
    void remove_checked(std::uint32_t slot);
    void replace(ModelId id, std::shared_ptr<const Geometry> geometry);
    template <class Change>
    void change_map(ModelId id, Change change);
    const OccupancyMap& map_of(ModelId id);
    void changed() { taken_in.store(false, std::memory_order_release); }

    bool runs(std::string_view stage) const;
    void need_tree(Model& model);
    PairTask task_of(std::uint32_t a, std::uint32_t b)
    {
        return {0, &bodies.model(a), &bodies.model(b), &bodies.pose(a), &bodies.pose(b)};
    }
    /// Passes the changes to the broad phase and lists the AABBs to update.
    void take_in_changes();
    void find_events();
    void look_ahead();
    /// For const calls: updates AABBs and broad phase if there are changes.
    void bring_up_to_date();

    class Lease;
    template <class Found, class Item, class Work>
    void in_parts(std::span<const Item> items, std::size_t chunk, std::vector<Found>& found,
                  std::vector<std::size_t>& ends, Work work);
};

} // namespace oncollide
