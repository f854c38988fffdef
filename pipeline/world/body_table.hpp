#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/rigid_motion.hpp>

namespace oncollide {

/// Changes since the last frame, as lists of slots for the broad phase; each slot is at most once in each list.
struct BodyChanges {
    std::vector<std::uint32_t> removed, added_dynamic, added_static, moved, made_static, made_dynamic;
    std::vector<std::uint32_t> fresh; ///< bodies that are new or have a new geometry: cached data of them is void
    void clear();
    bool empty() const;
};

/// The bodies of a World, as columns by slot, and their changes. The slot freed last is reused first, under a new
/// generation.
class BodyTable {
public:
    struct Init {
        Model* model;
        ModelId model_id;
        Eigen::Isometry3d pose;
        std::uint32_t layer, mask, group;
        std::uint64_t user;
        bool is_static;
    };

    /// @param world  the tag of the World in its ids
    explicit BodyTable(std::uint16_t world) : world_(world) {}

    void reserve(std::size_t slots);
    std::uint32_t add(const Init& body); ///< returns the slot
    void remove(std::uint32_t slot);
    void set_pose(std::uint32_t slot, const Eigen::Isometry3d& pose);
    /// Moves the body to the end of the motion, which it keeps until end_motions().
    void set_motion(std::uint32_t slot, RigidMotion motion);
    void end_motions(); ///< the bodies count as moved once more: their boxes shrink
    /// The way of the body in this frame; null: none.
    const RigidMotion* motion(std::uint32_t slot) const
    {
        return slot < motion_of_.size() && motion_of_[slot] ? &motions_[motion_of_[slot] - 1] : nullptr;
    }
    bool any_motion() const { return !motions_.empty(); }
    void set_filter(std::uint32_t slot, std::uint32_t layer, std::uint32_t mask, std::uint32_t group);
    void set_static(std::uint32_t slot, bool is_static);
    void set_asleep(std::uint32_t slot, bool asleep);
    void set_model(std::uint32_t slot, Model* model, ModelId id);
    /// The vertices of the body's mesh have moved by at most this distance.
    void deform(std::uint32_t slot, double moved);
    void set_user(std::uint32_t slot, std::uint64_t user);

    void exclude(std::uint32_t a, std::uint32_t b);
    void include(std::uint32_t a, std::uint32_t b);
    bool excluded(std::uint32_t a, std::uint32_t b) const
    {
        return !excluded_.empty() && excluded_.contains(key(a, b));
    }
    bool any_excluded() const { return !excluded_.empty(); }
    std::uint64_t exclusions_version() const { return exclusions_version_; } ///< grows when an exclusion changes

    std::uint32_t slots() const { return static_cast<std::uint32_t>(state_.size()); }
    std::uint32_t size() const { return size_; } ///< bodies
    bool alive(std::uint32_t slot) const { return slot < state_.size() && (state_[slot] & alive_bit); }
    bool valid(BodyId id) const { return alive(id.slot) && this->id(id.slot) == id; }
    BodyId id(std::uint32_t slot) const { return {slot, generation(slot), world_}; }
    bool is_static(std::uint32_t slot) const { return state_[slot] & static_bit; }
    bool is_asleep(std::uint32_t slot) const { return state_[slot] & asleep_bit; }
    bool rests(std::uint32_t slot) const { return state_[slot] & (static_bit | asleep_bit); } ///< static or asleep
    std::uint32_t dynamic() const { return dynamic_; } ///< bodies that are not static

    Model& model(std::uint32_t slot) const { return *models_[model_of_[slot]].model; }
    ModelId model_id(std::uint32_t slot) const { return models_[model_of_[slot]].id; }
    const Eigen::Isometry3d& pose(std::uint32_t slot) const { return poses_[slot]; }
    std::uint32_t layer(std::uint32_t slot) const { return layers_[slot]; }
    std::uint32_t mask(std::uint32_t slot) const { return masks_[slot]; }
    std::uint32_t group(std::uint32_t slot) const { return groups_[slot]; }
    std::uint64_t user(std::uint32_t slot) const { return slot < user_.size() ? user_[slot] : 0; }
    /// Upper bound on the distance that any point of the body has moved in total, to any pose on its ways, metres; only
    /// differences are meaningful.
    double travel(std::uint32_t slot) const { return travel_[slot]; }
    double stretch(std::uint32_t slot) const { return stretch_[slot]; } ///< of its pose: see placed_pair.hpp

    /// Prefetches the body's data: bodies are scattered in memory.
    void prefetch(std::uint32_t slot) const
    {
        prefetch_all_of(boxes_[slot]), prefetch_all_of(poses_[slot]);
        prefetch_all_of(model_of_[slot]), prefetch_all_of(travel_[slot]), prefetch_all_of(stretch_[slot]);
    }

    void prefetch_model(std::uint32_t slot) const { oncollide::prefetch(&model_of_[slot]); }

    std::vector<Aabb>& boxes() { return boxes_; } ///< by slot; world, metres
    const std::vector<Aabb>& boxes() const { return boxes_; }
    /// The columns that the broad phase reads.
    BodyColumns columns() const
    {
        return {boxes_, layers_, masks_,
                any_group_ ? std::span<const std::uint32_t>(groups_) : std::span<const std::uint32_t>{},
                filters_version_};
    }

    /// Overwrites `changes` with the changes since the last call.
    void take_changes(BodyChanges& changes);
    std::size_t bytes() const;
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it.
    /// Cost: O(slots + exclusions).
    std::string validate() const;

private:
    enum State : std::uint8_t {
        alive_bit = 1,
        static_bit = 2,
        known_bit = 4,        ///< in the broad phase
        known_static_bit = 8, ///< static in the broad phase
        fresh_bit = 16,       ///< new, or with a new geometry
        moved_bit = 32,       ///< pose or filter changed
        listed_bit = 64,      ///< in changed_
        asleep_bit = 128,
    };
    static std::uint64_t key(std::uint32_t a, std::uint32_t b)
    {
        return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
    }
    /// Generations begin at 1.
    std::uint16_t generation(std::uint32_t slot) const
    {
        return static_cast<std::uint16_t>(1 + (slot < removed_.size() ? removed_[slot] : 0));
    }
    void mark(std::uint32_t slot, std::uint8_t how);
    void note_model(std::uint32_t slot, Model* model, ModelId id);
    struct UsedModel {
        Model* model = nullptr;
        ModelId id{};
    };

    std::vector<std::uint8_t> state_;
    std::vector<std::uint16_t> removed_;  ///< bodies that the slot held before; 0 beyond its end
    std::vector<UsedModel> models_;       ///< by model slot
    std::vector<std::uint32_t> model_of_; ///< slot in models_
    std::vector<Eigen::Isometry3d> poses_;
    std::vector<std::uint32_t> layers_, masks_, groups_;
    std::vector<std::uint64_t> user_; ///< 0 beyond its end
    std::vector<double> travel_, stretch_;
    std::vector<Aabb> boxes_;
    std::vector<std::uint32_t> free_, changed_;
    std::unordered_set<std::uint64_t> excluded_;
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> partners_; ///< by slot: all bodies it was ever
                                                                             ///< excluded from
    std::uint32_t size_ = 0, dynamic_ = 0;
    const std::uint16_t world_;
    std::vector<std::uint32_t>
        motion_of_;                     ///< by slot: one more than the index of its motion; 0, or beyond its end: none
    std::vector<RigidMotion> motions_;  ///< motions of this frame
    std::vector<std::uint32_t> moving_; ///< their slots
    bool any_group_ = false;
    std::uint64_t filters_version_ = 1; ///< grows when a layer, a mask or a group changes
    std::uint64_t exclusions_version_ = 0;
};

/// Updates the world AABBs of new and moved bodies: tight, or around bounding spheres.
void update_boxes(BodyTable& bodies, const BodyChanges& changes, bool tight, int threads);

} // namespace oncollide
