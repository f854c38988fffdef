#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>

// Who takes part in the benchmark of the broad phase. One file a library; each adds what it has to the list.
namespace oncollide::tools {

/// What everybody is told about a frame.
struct BoxFrame {
    std::span<const Aabb> boxes;
    std::span<const std::uint32_t> moved; ///< boxes that changed since the frame before, ascending
    std::span<const std::uint8_t> is_static;
};

/// One way to find all overlapping boxes, with whatever it keeps from frame to frame.
class BroadPeer {
public:
    virtual ~BroadPeer() = default;
    /// Takes in frame 0.
    virtual void start(const BoxFrame& frame) = 0;
    /// Takes in the next frame. `pairs` is overwritten: every two boxes that overlap and are not both static, each
    /// once, in any order.
    virtual void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) = 0;
    /// What its delimitation did in the last frame; null: it has none. Not timed.
    virtual BroadPhase* delimited() { return nullptr; }
};

struct Contender {
    std::string name; ///< as in --only
    std::string what; ///< library and class
    enum class Group { oncollide, baseline, debian } group = Group::debian;
    bool threaded = false;              ///< can use several threads
    std::size_t most = ~std::size_t{0}; ///< boxes above which it would take too long
    std::function<std::unique_ptr<BroadPeer>(int threads)> make;
};

/// A library that this build does without.
struct MissingPeer {
    std::string library, package; ///< Debian's name
};

template <class Kind>
struct ContenderList {
    std::vector<Kind> all;
    std::vector<MissingPeer> missing;

    /// Leaves those that the list names, in its order; an empty list leaves all. Throws Error{usage} with the names.
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

/// Exact, whatever the sizes of the boxes: the judge of all others.
std::unique_ptr<BroadPeer> make_grid_peer();
std::unique_ptr<BroadPeer> make_brute_peer();

} // namespace oncollide::tools
