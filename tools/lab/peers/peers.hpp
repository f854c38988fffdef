// The libraries and methods that benchmarks compare, one file per library, grouped by their queries.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/walks/triangle_tests.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide::tools {

enum class Group { oncollide, baseline, debian };

/// Reliability of a contender's results. Conservative: no missed collisions, but false positives. Approximate: nothing
/// is promised; errors are only counted.
enum class Promise { exact, conservative, approximate };

/// A library or a method in a benchmark.
template <class Peer, class... Input>
struct Contender {
    std::string name; ///< as in --only
    std::string what; ///< library and class or structure
    Group group = Group::debian;
    Promise promise = Promise::exact;
    bool threaded = false;                            ///< can use several threads
    std::size_t least = 1, most = ~std::size_t{0};    ///< boxes, or triangles per mesh: it crashes with fewer, or would
                                                      ///< take too long with more
    bool has_all_pairs = false, has_distance = false; ///< in addition to the main query
    /// Builds the data that it keeps between queries.
    std::function<std::unique_ptr<Peer>(Input...)> make;
};

/// Makes a Peer from the arguments of the benchmark and `more`.
template <class Peer>
auto maker(auto... more)
{
    return [=](const auto&... given) { return std::make_unique<Peer>(given..., more...); };
}

/// A library that this build lacks.
struct MissingPeer {
    std::string library, package; ///< Debian's name
};

/// Names the libraries that this build lacks on standard output.
void print_missing(std::span<const MissingPeer> missing);

template <class Kind>
struct ContenderList {
    std::vector<Kind> all;
    std::vector<MissingPeer> missing;

    /// Keeps only the named contenders, in that order; an empty list keeps all. Throws Error{usage} with the valid
    /// names.
    void keep(const std::string& only);
};

/// The input of a frame of boxes, the same for all contenders.
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
using BroadContender = Contender<BroadPeer, int>; ///< made for a number of threads

/// A method for queries of two meshes, of which the second moves. All distances in metres.
class NarrowPeer {
public:
    virtual ~NarrowPeer() = default;
    /// True if the surfaces meet. Conservative methods also return true if they are uncertain.
    virtual bool collides(const Eigen::Isometry3d& b) = 0;
    /// Finds all pairs of triangles that meet, each once, in any order; overwrites `pairs`.
    virtual void all_pairs(const Eigen::Isometry3d&, std::vector<TrianglePair>& pairs) { pairs.clear(); }
    /// Distance of the surfaces, 0 if they meet.
    virtual double distance(const Eigen::Isometry3d&) { return 0; }
    /// Figures of its data and its queries so far, in words; empty: none.
    virtual std::string figures() const { return {}; }
};
using NarrowContender = Contender<NarrowPeer, const Mesh&, const Mesh&>;

/// Finds the triangles of a mesh that meet each other beyond the vertices and edges that they share.
class SelfPeer {
public:
    virtual ~SelfPeer() = default;
    /// Overwrites `found` with all pairs, a < b, each once, in any order.
    virtual void pairs(std::vector<TrianglePair>& found) = 0;
};
using SelfContender = Contender<SelfPeer, const Mesh&>;

/// Two meshes in one frame, whose vertices move.
class DeformPeer {
public:
    virtual ~DeformPeer() = default;
    /// @param which  0: the first mesh, 1: the second
    virtual void set_vertices(int which, std::span<const Eigen::Vector3d> positions) = 0;
    /// Finds all pairs of triangles that meet, each once, in any order; overwrites `pairs`.
    virtual void all_pairs(std::vector<TrianglePair>& pairs) = 0;
    /// The boxes that the first mesh's tree fitted anew since it was made, and the boxes of the whole tree; 0: unknown.
    /// The tree may grow whole.
    virtual std::uint64_t boxes_refitted() const { return 0; }
    virtual std::uint64_t boxes() { return 0; }
    /// Bytes of the first mesh with its tree; 0: unknown.
    virtual std::size_t bytes() const { return 0; }
};
using DeformContender = Contender<DeformPeer, const Mesh&, const Mesh&>;

/// Finds which segments meet a mesh.
class RayPeer {
public:
    virtual ~RayPeer() = default;
    /// Sets hit[i] to 1 if segments[i] meets the mesh, else to 0.
    virtual void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) = 0;
};
using RayContender = Contender<RayPeer, const Mesh&>;

/// A body of the benchmark of contacts: a mesh, a terrain or a shape.
struct ContactPeerBody {
    const Geometry* geometry;
    bool is_static;
    Eigen::Isometry3d pose; ///< at first
};

/// Finds contacts for a solver.
class ContactPeer {
public:
    virtual ~ContactPeer() = default;
    /// Places all bodies.
    virtual void place(std::span<const Eigen::Isometry3d> poses) = 0;
    /// Finds the contacts of all pairs of which a body moves. Returns their number.
    virtual std::size_t contacts() = 0;
    /// Finds the contacts of these pairs alone, anew in each call. All calls have the same
    /// pairs, so the peer may keep memory for each.
    virtual std::size_t contacts_of(std::span<const BodyPair> pairs) = 0;
    /// Changes the heights of a terrain, in its frame; its lowest and its highest height stay. Returns false if it
    /// cannot.
    virtual bool set_heights(std::size_t /*body*/, const TerrainRectangle&, std::span<const double>) { return false; }
};
using ContactContender = Contender<ContactPeer, std::span<const ContactPeerBody>>;

/// A body that a library moves by its own physics. Its centre of mass is the origin of its frame.
struct PhysicsBody {
    const Geometry* geometry;
    Eigen::Isometry3d pose;
    double mass;             ///< kg; 0: it does not move
    Eigen::Vector3d inertia; ///< about the axes of its frame
};

struct PhysicsSettings {
    double dt = 0.008, friction = 0.5;
    double damping = 0.1, spin_damping = 0.6; ///< shares of the speed and the spin that are lost in a second
};

/// The figures of a step.
struct PhysicsStep {
    double detection_ms = 0, solver_ms = 0;
    std::size_t contacts = 0, awake = 0; ///< awake: bodies
    double fastest = 0;                  ///< speed of the fastest body, m/s
};

/// A library that finds contacts and solves them.
class PhysicsPeer {
public:
    virtual ~PhysicsPeer() = default;
    virtual PhysicsStep step() = 0;
    /// Overwrites `poses` with the poses of all bodies.
    virtual void poses(std::vector<Eigen::Isometry3d>& poses) const = 0;
};
using PhysicsContender = Contender<PhysicsPeer, std::span<const PhysicsBody>, const PhysicsSettings&>;

using BroadContenders = ContenderList<BroadContender>;
using NarrowContenders = ContenderList<NarrowContender>;
using SelfContenders = ContenderList<SelfContender>;
using DeformContenders = ContenderList<DeformContender>;
using RayContenders = ContenderList<RayContender>;
using ContactContenders = ContenderList<ContactContender>;
using PhysicsContenders = ContenderList<PhysicsContender>;

struct Contenders {
    BroadContenders broad;
    NarrowContenders narrow;
    RayContenders rays;         ///< of other libraries
    ContactContenders contacts; ///< of other libraries
    PhysicsContenders physics;  ///< of other libraries
    SelfContenders self;        ///< of other libraries
    DeformContenders deform;
};

/// All contenders of this build, and the libraries that it lacks.
Contenders all_contenders();

// Each adds the contenders of one library.
void add_oncollide(Contenders& all);
void add_fcl(Contenders& all);
void add_fcl_deform(Contenders& all);
void add_deform(Contenders& all); ///< oncollide's
void add_embree(Contenders& all);
void add_bullet(Contenders& all);
void add_ode(Contenders& all);
void add_cgal(Contenders& all);
void add_cgal_self(Contenders& all);
void add_baselines(Contenders& all);

/// Sphere-trees of this depth, and FCL for poses that are left over, if requested.
NarrowContender sphere_walk(int depth, bool then_fcl);
/// Exact for boxes of any size: the judge of all others.
std::unique_ptr<BroadPeer> make_grid_peer();
std::unique_ptr<BroadPeer> make_brute_peer();

} // namespace oncollide::tools
