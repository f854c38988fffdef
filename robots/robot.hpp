#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// How a joint moves its child link. A configuration has 1 number (m or rad) for each revolute, continuous and
/// prismatic joint, 3 for a planar one (x, y, angle), 7 for a floating one (x, y, z, qx, qy, qz, qw), and none for a
/// fixed joint or one that mimics another.
enum class JointKind : std::uint8_t { fixed, revolute, continuous, prismatic, planar, floating };
ONCOLLIDE_API std::string_view name_of(JointKind kind);

struct RobotJoint {
    std::string name;
    JointKind kind = JointKind::fixed;
    std::uint32_t parent = 0, child = 0;                      ///< links
    Eigen::Isometry3d origin = Eigen::Isometry3d::Identity(); ///< frame of the joint in the parent link's frame
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();          ///< unit, in the joint's frame; planar: the normal
    double lower = -std::numeric_limits<double>::infinity(),  ///< limits of a revolute or a prismatic joint, m or rad
        upper = std::numeric_limits<double>::infinity();
    /// The joint whose value, times `multiplier` plus `offset`, is this joint's; -1: it has a value of its own.
    std::int32_t mimics = -1;
    double multiplier = 1, offset = 0;
};

/// A geometry at a pose in its link's frame.
struct LinkGeometry {
    std::shared_ptr<const Geometry> geometry;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

struct RobotLink {
    std::string name;
    std::vector<LinkGeometry> collision; ///< may be empty
};

struct RobotGroup {
    std::string name;
    std::vector<std::uint32_t> links, joints; ///< sorted
};

/// Named values of some joints.
struct RobotState {
    std::string name, group;
    struct Value {
        std::uint32_t joint;
        std::vector<double> numbers;
    };
    std::vector<Value> values;
};

/// A tree of links, connected by joints.
struct RobotDescription {
    std::string name;
    std::vector<RobotLink> links;
    std::vector<RobotJoint> joints;
    std::vector<std::pair<std::uint32_t, std::uint32_t>>
        excluded; ///< pairs of links that are not tested; a < b, sorted
    std::vector<RobotGroup> groups;
    std::vector<RobotState> states;
};

/// Files besides the URDF file.
struct RobotReading {
    /// An SRDF file: excluded pairs, groups and states. Without one, the pairs of links that a joint connects are
    /// excluded.
    std::filesystem::path srdf{};
    /// The folders of packages: `package://NAME/FILE` is FOLDER/FILE. Other packages are looked for by their names, in
    /// the folder of the URDF and in those above it.
    std::map<std::string, std::filesystem::path> packages{};
};

/// Reads a URDF file: the tree of links, and all collision geometry (meshes in the formats of load_mesh, boxes,
/// spheres, cylinders, capsules). Visual geometry, masses and unknown elements are ignored. Throws Error{no_input} for
/// a missing file and Error{bad_data} that names the file, the line and the element; a file for xacro is
/// expanded if that program is on the PATH, else refused with the command that expands it. Throws Error{usage} in a
/// build without ONCOLLIDE_XML.
///
/// It reads MJCF, MuJoCo's XML, too: bodies are links, with their geoms that can collide, and hinges and slides have
/// the numbers of MuJoCo's qpos. The pairs that MuJoCo does not test are excluded; the pose of the file, "qpos0", and
/// keyframes are states. Throws Error{usage} for an SRDF file beside it.
ONCOLLIDE_API RobotDescription load_robot(const std::filesystem::path& file, const RobotReading& reading = {});

/// The result of one configuration: the worst verdict of its pairs, colliding before undecided before within.
struct RobotFinding {
    static constexpr std::uint32_t no_link = 0xffffffffu;

    double bound = 0; ///< metres. separate: the World's clearance; within the padding: that clearance;
                      ///< otherwise the bound of the pair below
    Verdict verdict = Verdict::separate;
    /// The pair with this verdict that was found first, or the one with the least bound if none collides.
    std::uint32_t link = no_link;  ///< no_link: all pairs are separate
    std::uint32_t other = no_link; ///< a link of the robot; no_link: the pair is with `body`
    BodyId body{};
};

/// How close links may come to bodies and to each other: pairs that are closer are `within`. Metres, 0 or more. Where
/// the World's clearance is larger, it counts.
struct RobotPadding {
    double environment = 0; ///< links and bodies
    double self = 0;        ///< two links
    struct OfLink {
        std::uint32_t link;
        double clearance;
    };
    std::vector<OfLink> links{}; ///< of a link and all bodies, instead of `environment`
    struct OfBody {
        BodyId body;
        double clearance;
        std::uint32_t link = RobotFinding::no_link; ///< no_link: all links
    };
    std::vector<OfBody> bodies{}; ///< instead of `links`; an entry with a link counts before one without
    struct OfPair {
        std::uint32_t a, b; ///< links
        double clearance;
    };
    std::vector<OfPair> pairs{}; ///< of two links, instead of `self`
};

/// Two links, or a link and a body, that may be in contact: they are not tested.
struct AllowedContact {
    std::uint32_t link;
    std::uint32_t other = RobotFinding::no_link; ///< a link; no_link: `body`
    BodyId body{};
};

/// Copies of a World in which some bodies have other poses. They share everything else; bodies that are not listed
/// stay as in the World.
struct WorldCopies {
    std::span<const BodyId> bodies;
    std::span<const Eigen::Isometry3d> poses; ///< by copy, then as `bodies`
};

/// The tests of Robot::check().
struct RobotCheck {
    bool self = true, environment = true;
    CollisionFilter filter{}; ///< filter of the links, against the World's bodies
};

/// The result of an edge: the motion between two configurations.
struct RobotEdgeFinding {
    /// Certified: without contact before this share of the edge, from 0 to 1. For a planner, the last valid share.
    double clear_until = 0;
    /// At this share a pair certainly has the verdict below; infinity: no such share was found.
    double contact_by = std::numeric_limits<double>::infinity();
    /// separate: the whole edge is without contact. undecided: no contact was found, but a pair comes closer than
    /// RobotEdgeCheck::tolerance can resolve, or most_tests was reached. Other verdicts are the result of check() at
    /// contact_by.
    Verdict verdict = Verdict::undecided;
    // The pair with this verdict, as in RobotFinding. If undecided, the first pair at clear_until.
    std::uint32_t link = RobotFinding::no_link, other = RobotFinding::no_link;
    BodyId body{};
};

/// The tests of Robot::check_edges().
struct RobotEdgeCheck {
    RobotCheck pairs{};
    /// Bound on contact_by - clear_until, as a share of the edge: at least 1e-9. The times differ by more, or the edge
    /// stays undecided, if before the contact a pair is closer than it moves in this share.
    double tolerance = 1e-4;
    /// Find the first contact. False: any contact ends the search; clear_until is then only a lower bound.
    bool first = true;
    std::size_t most_tests = 100'000; ///< tests of pairs, per edge
};

/// The distances that Robot::distances() finds.
struct RobotDistanceOptions {
    RobotCheck pairs{};
    double tolerance = 0; ///< metres, >= 0: how far apart the bounds may be, besides rounding
    /// Metres, >= 0: pairs that are farther apart are left out.
    double cutoff = std::numeric_limits<double>::infinity();
    bool every_pair = false; ///< false: the least distance of a configuration
    bool gradients = true;
    /// Measure how deep pairs are that meet. False: their distance is 0, without a normal and a gradient, and the first
    /// that is found is the nearest.
    bool depths = true;
};

/// The signed distance of a link and another link or a body: above 0 they are apart; below 0 the other one has to move
/// by its amount along `normal` until they are. For several geometries of a link, the least of their distances.
struct RobotDistance {
    /// Certified bounds, metres: of the distance, or of minus the depths of the deepest region (ManifoldRegion). lower
    /// is minus infinity where they meet and have no manifold, as cooked meshes that are read on demand.
    double lower = 0, upper = 0;
    std::uint32_t link = RobotFinding::no_link;
    std::uint32_t other = RobotFinding::no_link; ///< a link of the robot; no_link: the pair is with `body`
    BodyId body{};
    /// The nearest points of the link and of the other one, or the points of the deepest contact. World frame.
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), other_point = Eigen::Vector3d::Zero();
    /// Unit, world frame: from the link to the other, which moves away along it; 0 where it has no manifold.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    /// False: points or normals with other gradients are as near, within rounding: parallel edges or faces, another
    /// pair, bodies that meet. The points, the normal and the gradient are then one choice of several. Parts of one
    /// pair that are not neighbours are not compared.
    bool unique = true;
};

/// The distances of configurations.
struct RobotDistances {
    /// Configuration i has the pairs offsets[i] to offsets[i + 1] - 1, the nearest first.
    std::vector<std::size_t> offsets;
    std::vector<RobotDistance> pairs;
    std::vector<double> gradients; ///< by pair, width() numbers: derivatives of its distance
};

/// The least distance of an edge: the motion between two configurations.
struct RobotEdgeClearance {
    /// Certified bounds of the least distance of all pairs on the whole edge, metres; both 0 where a pair meets, both
    /// infinite without any pair.
    double lower = std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
    double at = 0; ///< the share of the edge at which the pair below is `upper` apart
    std::uint32_t link = RobotFinding::no_link, other = RobotFinding::no_link; ///< as in RobotFinding
    BodyId body{};
};

struct RobotClearanceOptions {
    RobotCheck pairs{};
    double tolerance = 1e-3;          ///< metres, above 0: how far apart the bounds may be
    std::size_t most_tests = 100'000; ///< measured pairs, per edge; then the bounds stay farther apart
};

/// A robot whose links are models of a World. Any number of robots may share one. Its calls throw Error{usage} for a
/// World that is not the one it was made for, and for configurations of another width than width().
///
///     const RobotDescription panda = load_robot("panda.urdf", {.srdf = "panda.srdf"});
///     World world;
///     ... // add the environment
///     Robot robot(world, panda);
///     robot.check(world, configurations, findings); // many configurations, without bodies
///
///     robot.add_bodies(world); // or: as bodies, in frames
///     robot.set_joints(world, configuration);
///     world.step();
///
/// Const calls may run on many threads at once as long as no other call on the robot or the World does.
class ONCOLLIDE_API Robot {
public:
    /// Adds the geometries of all links to the World. `base` is the pose of the root link.
    /// Throws Error{bad_data} that names the link or the joint for a description that a file could not hold: not a
    /// tree, numbers of links or joints that do not exist, two of one name, an axis that is not unit, limits, mimics or
    /// states that make no sense, geometry that check_geometry() refuses; for poses that are not rigid; and as
    /// Bodies::add() for a mesh that is not closed. Excluded pairs may come in any order.
    Robot(World& world, RobotDescription description, const Eigen::Isometry3d& base = Eigen::Isometry3d::Identity());
    ~Robot();
    Robot(Robot&&) noexcept;
    Robot& operator=(Robot&&) noexcept;

    const RobotDescription& description() const;
    std::size_t width() const; ///< numbers of a configuration, in the order of the joints in the description
    /// The name of each number: the joint, or for planar and floating joints JOINT/x, JOINT/y, JOINT/angle, JOINT/qx
    /// and so on.
    const std::vector<std::string>& names() const;
    /// All numbers 0, or the nearest limit; floating joints at the identity.
    std::vector<double> neutral() const;
    /// Sets the numbers of the joints of a state. Throws Error{usage} for an unknown name; `group` may be empty if one
    /// group alone has a state of this name.
    void apply_state(std::string_view state, std::string_view group, std::span<double> configuration) const;
    /// Throws Error{bad_data} that names a joint whose number is not finite, or whose quaternion is not unit within
    /// 1e-6; with `limits` also for a number out of the joint's limits.
    void check_configuration(std::span<const double> configuration, bool limits) const;
    /// Sets the pose of each link in the world. Cost: 20 to 50 nanoseconds per joint.
    void link_poses(std::span<const double> configuration, std::span<Eigen::Isometry3d> poses) const;
    /// Sets the derivatives of a point's position (rows 0 to 2, m) and of its link's rotation (rows 3 to 5, rad) by
    /// each number of the configuration: 6 rows of width() numbers. Throws Error{usage} for a link that does not exist,
    /// and for another size of `rows`.
    /// @param point  in the link's frame
    void jacobian(std::span<const double> configuration, std::uint32_t link, const Eigen::Vector3d& point,
                  std::span<double> rows) const;
    /// Sets the pose of the root link. Throws Error{bad_data} for a pose that is not rigid.
    void set_base(const Eigen::Isometry3d& base);

    /// Fixes a model of the World to a link, as an object in a gripper. Pairs of the object with that link, and with
    /// the links in `touching`, are not tested. Returns its number. Do not call it while the robot has bodies. Throws
    /// Error{usage} for links that do not exist, and as queries of the World for the model.
    std::uint32_t attach(World& world, std::uint32_t link, ModelId model, const Eigen::Isometry3d& pose,
                         std::span<const std::uint32_t> touching = {});
    /// Removes all attached objects; the models stay. Do not call it while the robot has bodies.
    void detach_all();

    /// Replaces the padding, for check() and check_edges(). A configuration is then tested until a pair collides or is
    /// within its clearance. Throws Error{usage} for links that do not exist, and for a clearance that is negative, NaN
    /// or beyond 1e6.
    void set_padding(const RobotPadding& padding);
    const RobotPadding& padding() const;
    /// Replaces the contacts that are allowed besides the description's excluded pairs. An entry with a body that was
    /// removed does nothing. Do not call it while the robot has bodies. Throws Error{usage} for links that do not
    /// exist.
    void set_allowed(std::span<const AllowedContact> allowed);

    // --- Bodies of the World.
    /// Adds a body for each geometry, at neutral(), and excludes the pairs that are not tested. model and pose of
    /// `spec` are not used.
    void add_bodies(World& world, const BodySpec& spec = {});
    void set_joints(World& world, std::span<const double> configuration);
    void remove_bodies(World& world);       ///< except bodies that were removed before
    std::span<const BodyId> bodies() const; ///< by geometry: links in order, then attached objects; empty: none
    std::uint32_t link_of(std::size_t body) const;

    // --- Many configurations, without bodies.
    /// Sets findings[i] for numbers i * width() up to (i + 1) * width(), with the World's settings of accuracy and
    /// threads. A configuration is tested until a pair collides. Bodies of this robot are not tested. With max_error
    /// and an automatic exact level, it decides exactly where OBB trees refine, as that takes less time than a bound.
    /// Throws as check_configuration() without limits. Cost: 0.5 to 2 microseconds per configuration for an arm among
    /// ten bodies.
    void check(const World& world, std::span<const double> configurations, std::span<RobotFinding> findings,
               const RobotCheck& what = {}) const;

    /// Tests configuration i in copy i of the World: the result of check() in a World whose bodies are there. Memory of
    /// a call does not grow with the number of copies. Throws as check() above, Error{usage} for a body that is listed
    /// twice, not in the World or the robot's, and for another number of poses, and Error{bad_data} for a pose that is
    /// not rigid. Cost: half as much again as check(), for 20 bodies.
    void check(const World& world, const WorldCopies& copies, std::span<const double> configurations,
               std::span<RobotFinding> findings, const RobotCheck& what = {}) const;

    /// Sets the signed distances of configurations: the least of each, or one for each pair of links and each link and
    /// body within the cutoff. Pairs that are excluded, and bodies of this robot, are not measured. Gradients
    /// are the derivatives of the distance by each number of the configuration, m per m or rad; by the four numbers of
    /// a quaternion, too. Threads as check(); surfaces or solids as World::settings() say. Padding
    /// does not count. The same bits for any number
    /// of threads. Throws as check_configuration() without limits, and Error{usage} for a tolerance or a cutoff that is
    /// negative or NaN. Cost: 10 to 40 microseconds for the least distance of an arm of meshes among 40 bodies.
    void distances(const World& world, std::span<const double> configurations, RobotDistances& found,
                   const RobotDistanceOptions& options = {}) const;

    /// Checks whole edges: edge i begins at the numbers i * width() and following of `from`, and ends at the numbers of
    /// `to` at the same places. All numbers change at constant speed, floating joints rotate along the shorter arc. No
    /// contact is missed between samples: each pair is tested in windows of time, with an upper bound on how far its
    /// links move in them (Schwarzer, Saha, Latombe: Adaptive dynamic collision checking, 2005). A pair nested without
    /// contact of surfaces (Mode::solid) is found where check() finds it, at both ends and the configurations between
    /// them that are checked first. Threads, errors and settings as check(), with the exact bounds of
    /// Pairs::distance(). For pairs between which few joints act, the robot remembers where they are apart; results do
    /// not depend on it. Cost: as much as 50 to 250 configurations; with the first contact, 100 to 600.
    void check_edges(const World& world, std::span<const double> from, std::span<const double> to,
                     std::span<RobotEdgeFinding> findings, const RobotEdgeCheck& what = {}) const;

    /// Sets the least distance of each edge, which is given as for check_edges(), without padding. Pairs are measured
    /// at the middle of windows; bounds on the motion of both sides bound the distance in the window, and the window
    /// with the least bound is halved until the bounds are within the tolerance. Threads and errors as check_edges().
    /// Cost: about a
    /// millisecond for an arm of meshes that is not in contact.
    void edge_clearance(const World& world, std::span<const double> from, std::span<const double> to,
                        std::span<RobotEdgeClearance> found, const RobotClearanceOptions& options = {}) const;

private:
    struct ONCOLLIDE_LOCAL Impl;
    class ONCOLLIDE_LOCAL Checker;
    class ONCOLLIDE_LOCAL DistanceFinder;
    class ONCOLLIDE_LOCAL EdgeChecker;
    class ONCOLLIDE_LOCAL EdgeMeasure;
    friend class Clearances;
    friend class SphereCull;
    friend class EdgeCull;
    friend class EdgeMotion;
    friend class EdgeSearch;
    friend class JointCells;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
