#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

#include "peers/common/contender.hpp"

// Contenders of the broad phase benchmark. One file per library; each adds its contenders to the list.
namespace oncollide::tools {

/// The input of a frame, the same for all contenders.
struct BoxFrame {
    std::span<const Aabb> boxes;
    std::span<const std::uint32_t> moved; ///< boxes that changed since the previous frame, ascending
    std::span<const std::uint8_t> is_static;
};

/// A method to find all overlapping boxes, with its data from frame to frame.
class BroadPeer {
public:
    virtual ~BroadPeer() = default;
    /// Receives frame 0.
    virtual void start(const BoxFrame& frame) = 0;
    /// Receives the next frame. Overwrites `pairs` with all pairs of boxes that overlap and are not both static, each
    /// once, in any order.
    virtual void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) = 0;
    /// Its delimitation, for the statistics of the last frame; null: none. Not timed.
    virtual BroadPhase* delimited() { return nullptr; }
};

/// Made for a number of threads.
using BroadContender = Contender<BroadPeer, int>;

using BroadContenders = ContenderList<BroadContender>;

BroadContenders broad_contenders();

void add_oncollide(std::vector<BroadContender>& all);
void add_baselines(std::vector<BroadContender>& all);
void add_fcl(std::vector<BroadContender>& all);
void add_embree(std::vector<BroadContender>& all);
void add_cgal(std::vector<BroadContender>& all);
void add_bullet(std::vector<BroadContender>& all);

/// Exact for boxes of any size: the judge of all others.
std::unique_ptr<BroadPeer> make_grid_peer();
std::unique_ptr<BroadPeer> make_brute_peer();

} // namespace oncollide::tools
