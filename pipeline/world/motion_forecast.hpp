#pragma once
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/pipeline/models/prefetcher.hpp>
#include <oncollide/pipeline/world/body_table.hpp>

namespace oncollide {

/// Predicts the motion of bodies by linear extrapolation.
class MotionForecast {
public:
    /// Parts of cooked meshes that moving bodies reach within `frames` frames, except parts found recently. Each call
    /// examines a share of the bodies; all are examined within `frames` / 2 calls. The broad phase must be up to date.
    std::vector<PrefetchPart> find(const BodyTable& bodies, std::span<const std::uint32_t> moved,
                                   const BroadPhase& broad, std::uint32_t frame, std::uint32_t frames);

private:
    struct Seen {
        Eigen::Vector3d centre;
        std::uint32_t frame = ~0u; ///< never
    };
    bool found_lately(const PrefetchPart& part) const;

    std::vector<Seen> seen_; ///< by slot
    std::unordered_map<const Model*, Aabb> found_;
    std::uint32_t found_since_ = 0;
    std::vector<std::uint32_t> slots_;
    std::vector<Aabb> boxes_;
    std::vector<AabbHit> hits_;
};

} // namespace oncollide
