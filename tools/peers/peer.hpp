#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

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

struct Contender {
    std::string name; ///< as in --only
    std::string what; ///< library and class
    enum class Group { oncollide, baseline, debian } group = Group::debian;
    bool threaded = false;              ///< can use several threads
    std::size_t most = ~std::size_t{0}; ///< largest number of boxes; more would take too long
    std::function<std::unique_ptr<BroadPeer>(int threads)> make;
};

/// A library that this build lacks.
struct MissingPeer {
    std::string library, package; ///< Debian's name
};

template <class Kind>
struct ContenderList {
    std::vector<Kind> all;
    std::vector<MissingPeer> missing;

    /// Keeps only the named contenders, in that order; an empty list keeps all. Throws Error{usage} with the valid
    /// names.
    void keep(const std::string& only);
};
using Contenders = ContenderList<Contender>;

Contenders broad_contenders();

void add_oncollide(std::vector<Contender>& all);
void add_baselines(std::vector<Contender>& all);
void add_fcl(std::vector<Contender>& all);
void add_embree(std::vector<Contender>& all);
void add_cgal(std::vector<Contender>& all);
void add_bullet(std::vector<Contender>& all);

/// Exact for boxes of any size: the judge of all others.
std::unique_ptr<BroadPeer> make_grid_peer();
std::unique_ptr<BroadPeer> make_brute_peer();

} // namespace oncollide::tools
