#pragma once
#include <span>
#include <unordered_map>
#include <vector>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/runs/ranks/body_record.hpp>
#include <oncollide/runs/ranks/partitioner.hpp>

namespace oncollide {

/// The World of one rank: holds the bodies in and around its region and decides the pairs whose overlap begins there.
///
/// If two AABBs overlap, the lowest corner of the overlap lies in both, so the rank that owns this point has both
/// bodies; the point has one owner, so each pair is decided once. The corner's coordinates are maxima of two
/// coordinates, so they are not rounded. Pairs are decided as (lower index, higher index), as in a World of all bodies.
class RankWorld {
public:
    /// Keeps references to `geometries` and `partition`. Throws Error{usage} for settings that make results depend on
    /// other bodies in the World, or with meshes that deform on earlier frames.
    RankWorld(const GeometryList& geometries, const Settings& settings, const Partitioner& partition, int rank);
    RankWorld(const RankWorld&) = delete;

    /// Passes on the vertices of meshes that deform. Call it before box() if geometries have changed.
    void renew_models();
    /// The body's world AABB, around its whole way, grown by half the clearance and its rounding; it determines the
    /// ranks that need the body.
    Aabb box(const BodyHere& body);

    /// Replaces the set of bodies: call begin(), add() once per body, then step().
    void begin();
    void add(const BodyHere& body); ///< keeps a reference until step()
    FrameView step();

    World& world() { return world_; }
    std::uint32_t gid(BodyId body) const { return static_cast<std::uint32_t>(world_.bodies().user(body)); }
    const std::string& name(BodyId body) const { return names_[body.slot]; }
    /// Number of pairs of the last step that include the body; 0 if this rank does not have it.
    std::uint32_t pairs_of(std::uint32_t gid) const;

private:
    struct Entry {
        BodyId id;
        std::uint32_t seen; ///< last step in which it was added
    };
    ModelId model_of(std::uint32_t geometry);
    void move(const BodyHere& body, BodyId id);
    void choose(std::span<const CandidatePair> pairs, std::span<PairChoice> choices);
    Aabb grown(const Aabb& box) const;

    const GeometryList& geometries_;
    const Partitioner& partition_;
    int rank_;
    World world_;
    double half_margin_;
    std::vector<std::optional<ModelId>> models_; ///< by geometry
    /// The meshes that deform, as their models have them.
    std::vector<std::shared_ptr<const Geometry>> known_;
    std::unordered_map<std::uint32_t, Entry> here_;
    std::vector<const BodyHere*> come_;
    std::uint32_t step_ = 0;
    std::vector<std::string> names_;   ///< by slot
    std::vector<std::uint32_t> pairs_; ///< by slot
};

/// Throws Error{usage} for settings that make results depend on the number of processes.
void check_for_ranks(const Settings& settings);
/// The same for meshes that deform: trees depend on the frames in which a process has tested them, so results that are
/// not exact would differ.
void check_for_ranks(const GeometryList& geometries, const Settings& settings);

} // namespace oncollide
