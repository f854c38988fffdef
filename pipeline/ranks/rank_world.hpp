#pragma once
#include <span>
#include <unordered_map>
#include <vector>

#include <oncollide/pipeline/ranks/body_record.hpp>
#include <oncollide/pipeline/ranks/partitioner.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide {

class Bodies;
struct BodyPair;

/// One rank's World: the bodies in and around its region, of which it decides the pairs whose overlap begins there.
///
/// Where the boxes of two bodies overlap, the overlap's lowest corner lies in both, so the rank that owns this point
/// has heard of both bodies; and a point has one owner, so each pair is decided once. The corner is the larger of two
/// coordinates, which rounds nothing. Pairs are decided as (lower index, higher index), as in one World of all.
class RankWorld {
public:
    /// Keeps references to `geometries` and `partition`. Throws Error{usage} for settings whose results depend on what
    /// else is in the World.
    RankWorld(const GeometryList& geometries, const Settings& settings, const Partitioner& partition, int rank);
    RankWorld(const RankWorld&) = delete;

    /// The world box of a body, grown by half the clearance and by its rounding: what decides which ranks must know it.
    Aabb box(const BodyHere& body);

    /// From now on these are the bodies here: begin, add each once, step.
    void begin();
    void add(const BodyHere& body); ///< which must stay until then
    FrameView step();

    World& world() { return world_; }
    std::uint32_t gid(BodyId body) const { return static_cast<std::uint32_t>(world_.user(body)); }
    const std::string& name(BodyId body) const { return names_[body.slot]; }
    /// In how many pairs of the last step a body was; 0 for one that is not here.
    std::uint32_t pairs_of(std::uint32_t gid) const;

private:
    struct Entry {
        BodyId id;
        std::uint32_t seen; ///< in which step
    };
    ModelId model_of(std::uint32_t geometry);
    void choose(const Bodies& bodies, std::vector<BodyPair>& pairs);
    Aabb grown(const Aabb& box) const;

    const GeometryList& geometries_;
    const Partitioner& partition_;
    int rank_;
    World world_;
    bool tight_;
    double half_margin_;
    std::vector<std::optional<ModelId>> models_; ///< by geometry
    std::unordered_map<std::uint32_t, Entry> here_;
    std::vector<const BodyHere*> come_;
    std::uint32_t step_ = 0;
    std::vector<std::string> names_;   ///< by slot
    std::vector<std::uint32_t> pairs_; ///< by slot
};

/// Throws Error{usage} for settings that several processes cannot honour: results would depend on how many there are.
void check_for_ranks(const Settings& settings);

} // namespace oncollide
