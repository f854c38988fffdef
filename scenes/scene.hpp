#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/columns.hpp>

namespace oncollide {

class Deformation;
class Recording;

/// A body of a Scene: its index. A Scene never removes bodies.
enum class SceneBodyId : std::uint32_t {};
/// A geometry of a Scene: its index.
enum class GeometryId : std::uint32_t {};

constexpr std::uint32_t index(SceneBodyId id)
{
    return static_cast<std::uint32_t>(id);
}
constexpr std::uint32_t index(GeometryId id)
{
    return static_cast<std::uint32_t>(id);
}

/// Arguments of add_body.
struct BodyInit {
    std::string name{}; ///< empty: a body without a name
    GeometryId geometry{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Motion motion = Still{};
    bool is_static = false;           ///< two static bodies never form a pair; its motion must be Still
    std::uint32_t layer = 1;          ///< bits: the layers that the body is on
    std::uint32_t mask = 0xffffffffu; ///< bits: the layers that the body collides with
    std::uint32_t group = 0;          ///< bodies of one group never collide with each other; 0: in no group
};

/// Receives the bodies of a scene that is read or generated without being stored.
class ONCOLLIDE_API BodySink {
public:
    virtual ~BodySink() = default;
    /// Whether the sink wants the body of this index. Other bodies are only counted; most are not even constructed.
    virtual bool wants(std::uint32_t body) const = 0;
    /// Called for the bodies that the sink wants, in ascending order, after the checks of Scene::add_body except the
    /// check for duplicate names.
    virtual void take(std::uint32_t body, BodyInit init) = 0;
};

/// Two bodies that never collide, by their indices.
struct ExcludedPair {
    std::uint32_t a, b; ///< a < b

    friend bool operator==(const ExcludedPair&, const ExcludedPair&) = default;
};

/// All data of a scene except its bodies, which are only counted.
struct ONCOLLIDE_API SceneInfo {
    std::string name;
    int frames = 1;  ///< number of frames of the scene's motion
    double pace = 1; ///< motion per frame, as a fraction: at 0.1 bodies move a tenth as far
    GeometryList geometries;

    std::vector<ExcludedPair> excluded; ///< in the order of the calls of exclude; may contain a pair twice

    /// Moves some bodies instead of their motions; null: there is no recording. Copies of a scene share it; only one of
    /// them may play it at a time.
    std::shared_ptr<Recording> recording;

    std::vector<std::string> warnings; ///< corrections made while loading (normalised quaternions, zero-area triangles)

    std::size_t size() const { return size_; } ///< number of bodies

    /// Throws Error{bad_data} if the name exists, and for a shape that check_shape refuses.
    GeometryId add(std::string geometry_name, GeometryData data, std::string recipe = {});
    /// The mesh deforms from now on: Mover writes its vertices, and this call writes the vertices of frame 0. Copies of
    /// a scene share the deformation; only one of them may play it at a time. Throws Error{bad_data} for a geometry
    /// that does not exist or is not a mesh in memory, and the errors of Deformation::move.
    void deform(GeometryId mesh, std::shared_ptr<Deformation> deformation);
    /// The geometry of that name, if it exists.
    std::optional<GeometryId> find_geometry(std::string_view geometry_name) const;

private:
    friend struct Scene;
    friend class SceneBuilder;
    void check_body(const BodyInit& body) const;
    void check_bodies_of(const Recording& source) const;
    /// @param names  the names of the bodies, for messages
    void exclude_pair(SceneBodyId a, SceneBodyId b, const NameColumn& names);

    std::size_t size_ = 0;
    NameIndex geometry_index_;
};

/// A scene: geometries, and bodies as columns indexed by index(SceneBodyId).
///
/// Move a body by set_pose between frames. Bodies a and b may collide if (layer a & mask b) and (layer b & mask a) are
/// not 0, not both are static, they are not in one group, and the pair is not excluded. add and add_body keep all
/// columns at one length. Geometries and bodies cannot be renamed or removed. A body takes 45 bytes, 72 more if it is
/// rotated, and the memory of its name and motion.
struct ONCOLLIDE_API Scene : SceneInfo {
    NameColumn names; ///< empty: a body without a name
    BodyColumn<GeometryId> geometry;
    PoseColumn poses; ///< current; rigid (rotation and translation), body frame to world
    MotionColumn motions;
    BodyColumn<std::uint8_t> is_static;
    BodyColumn<std::uint32_t> layers, masks;
    BodyColumn<std::uint32_t> groups; ///< 0: in no group
    ChangeLog changes;                ///< changes of all columns, by body
    double time = 0;                  ///< time of the motions, as Mover wrote it last: its frame times the pace

    /// Throws Error{bad_data} for a name that exists, an unknown geometry, a pose that is not finite or not rigid, a
    /// static body with a motion, or a motion that check_motion refuses.
    SceneBodyId add_body(BodyInit body);
    /// The pose at frame 0, before the first call of set_pose.
    Eigen::Isometry3d start_pose(std::size_t body) const;
    // Changes of one body. Invalid values (a pose that is not rigid) are reported when a World is stepped, not here.
    void set_pose(SceneBodyId body, const Eigen::Isometry3d& pose);
    void set_position(SceneBodyId body, const Eigen::Vector3d& position);
    void set_geometry(SceneBodyId body, GeometryId of);
    void set_static(SceneBodyId body, bool now);
    void set_layers(SceneBodyId body, std::uint32_t layer, std::uint32_t mask);
    void set_group(SceneBodyId body, std::uint32_t group);
    /// Moves the bodies of the recording to their poses at frame 0, which become their start poses. Throws
    /// Error{bad_data} for bodies that do not exist, are static or have a motion, and the errors of Recording::read.
    void record(std::shared_ptr<Recording> poses);
    /// Makes room for `bodies` bodies in all.
    void reserve(std::size_t bodies);
    /// The two bodies never collide. Throws Error{bad_data} for a body that does not exist, or if a and b are equal.
    void exclude(SceneBodyId a, SceneBodyId b);
    /// The body of that name, if it exists.
    std::optional<SceneBodyId> find(std::string_view body) const;
    /// The body's label in messages: its name, or "body 17" by its index.
    std::string label(SceneBodyId body) const;

private:
    void play_recording(int frame, bool as_start);
    std::size_t most_changes() const { return size() / 2 + 1024; }
    void note(SceneBodyId body, bool only_pose = false)
    {
        changes.note({index(body) & 0x7fffffffu, only_pose}, most_changes());
    }
    void expect_motion(); ///< makes room for the start poses and changes of the bodies with motions
    friend class Mover;

    NameIndex body_index_;
    PoseColumn starts_;                   ///< poses of the bodies that have moved
    std::vector<std::uint32_t> start_of_; ///< one more than the index in starts_, 0 for bodies that have not moved; may
                                          ///< be shorter than the bodies
};

/// Hands the bodies of a scene to a sink, with their poses at frame 0.
ONCOLLIDE_API void pass_bodies(const Scene& scene, BodySink& sink);

/// Writes the poses of every moving body, and the vertices of every mesh that deforms, at frame `frame` (>= 0), and
/// notes a body that passes keys as changed even where it comes back to its pose. Stateless except for Jitter, which
/// continues from the frame of the last call (and from the start if `frame` is smaller). A recording gives the poses of
/// the last whole frame at that time, and throws as Recording::read does. One Mover serves one scene, whose bodies must
/// all exist at the first call.
class ONCOLLIDE_API Mover {
public:
    void move(Scene& scene, int frame);

private:
    int last_frame_ = 0;
    bool ready_ = false;
};

} // namespace oncollide
