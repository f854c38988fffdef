#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/columns.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/ids.hpp>
#include <oncollide/scenes/motion.hpp>
#include <oncollide/scenes/recording.hpp>

namespace oncollide {

/// What add_body needs to know of a body.
struct BodyInit {
    std::string name{}; ///< empty: a body without a name
    GeometryId geometry{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Motion motion = Still{};
    bool is_static = false;           ///< promises never to move; static-static pairs are never formed
    std::uint32_t layer = 1;          ///< bits: the layers that the body is on
    std::uint32_t mask = 0xffffffffu; ///< bits: the layers that the body collides with
    std::uint32_t group = 0;          ///< bodies of one group never collide with each other; 0: in no group
};

/// Takes the bodies of a scene that holds none of them: see Scene(BodySink*).
class BodySink {
public:
    virtual ~BodySink() = default;
    /// Whether it wants the body of this index. The others are counted, and most are not even made.
    virtual bool wants(std::uint32_t body) const = 0;
    /// The bodies that it wants, ascending. They are checked as add_body does, but for names that another one has.
    virtual void take(std::uint32_t body, BodyInit init) = 0;
};

/// Two bodies that never collide, by their indices.
struct ExcludedPair {
    std::uint32_t a, b; ///< a < b

    friend bool operator==(const ExcludedPair&, const ExcludedPair&) = default;
};

/// Finds an index by name in constant time. The names are held by whom it indexes: name_of(index) gives them.
class NameIndex {
public:
    /// Takes `name` for `index`; false, changing nothing, when the name is taken.
    template <class NameOf>
    bool add(std::string_view name, std::uint32_t index, NameOf name_of);
    template <class NameOf>
    std::optional<std::uint32_t> find(std::string_view name, NameOf name_of) const;

private:
    struct Slot {
        std::uint32_t hash, index;
    };
    void grow();

    std::vector<Slot> slots_; ///< a power of two of them, at most half in use
    std::size_t used_ = 0;
};

/// Everything that exists: geometries, and bodies as columns indexed by index(BodyId).
///
/// Move a body by set_pose between frames. Bodies a and b may collide when (layer a & mask b) and
/// (layer b & mask a) are not 0, not both are static, they are not of one group, and the pair is not excluded.
/// Geometries and bodies are added by add and add_body, which keep the columns of one length; they are not renamed or
/// removed afterwards. A body takes 45 bytes, 72 more if it is turned, and what its name and its motion need.
struct Scene {
    Scene() = default;
    /// A scene too large to be held: its bodies go to `sink` as they are added, and none of its columns has a row.
    /// Null: a scene that holds its bodies.
    explicit Scene(BodySink* sink) : sink_(sink) {}

    std::string name;
    int frames = 1;  ///< how long the scene's motion is worth running
    double pace = 1; ///< how much of a frame's motion a frame plays: at 0.1 bodies move a tenth as far
    GeometryList geometries;

    NameColumn names; ///< empty: a body without a name
    BodyColumn<GeometryId> geometry;
    PoseColumn poses; ///< current; rigid (rotation and translation), body frame to world
    MotionColumn motions;
    BodyColumn<std::uint8_t> is_static;
    BodyColumn<std::uint32_t> layers, masks;
    BodyColumn<std::uint32_t> groups; ///< 0: in no group
    ChangeLog changes;                ///< of all columns, by body

    std::vector<ExcludedPair> excluded; ///< in the order of the calls of exclude; a pair may be there twice

    /// Moves some bodies in place of motions; null: none. Scenes that are copied share it, and play it one at a time.
    std::shared_ptr<Recording> recording;

    std::vector<std::string> warnings; ///< what loading put right (normalised quaternions, zero-area triangles)

    std::size_t size() const { return sink_ ? passed_ : names.size(); }
    bool holds_bodies() const { return !sink_; }
    /// Does nobody want the next body? Then it counts as added, and need not be made.
    bool skip_body() { return !wants(size()) && ++passed_; }
    bool wants(std::size_t body) const { return !sink_ || sink_->wants(static_cast<std::uint32_t>(body)); }

    /// Throws Error{bad_data} when a geometry of that name exists, and for a shape that check_shape refuses.
    GeometryId add(std::string geometry_name, GeometryData data, std::string recipe = {});
    /// Throws Error{bad_data} for a name that another body has, an unknown geometry, a pose that is not finite or not
    /// rigid, a static body with a motion, or a motion that check_motion refuses.
    BodyId add_body(BodyInit body);
    /// Where the body was before set_pose first moved it: at frame 0.
    Eigen::Isometry3d start_pose(std::size_t body) const;
    // Changes of one body. What a World refuses (a pose that is not rigid) it refuses when it is stepped.
    void set_pose(BodyId body, const Eigen::Isometry3d& pose);
    void set_position(BodyId body, const Eigen::Vector3d& position);
    void set_geometry(BodyId body, GeometryId of);
    void set_static(BodyId body, bool now);
    void set_layers(BodyId body, std::uint32_t layer, std::uint32_t mask);
    void set_group(BodyId body, std::uint32_t group);
    /// Its bodies go to their poses at frame 0, which are their start. Throws Error{bad_data} for bodies that do not
    /// exist, are static or have a motion, and what Recording::read throws. A scene that holds no bodies looks at
    /// their number alone.
    void record(std::shared_ptr<Recording> poses);
    /// Makes room for `bodies` bodies in all.
    void reserve(std::size_t bodies);
    /// The two never collide. Throws Error{bad_data} for a body that does not exist, or one with itself.
    void exclude(BodyId a, BodyId b);
    /// The body of that name, if there is one.
    std::optional<BodyId> find(std::string_view body) const;
    /// The geometry of that name, if there is one.
    std::optional<GeometryId> find_geometry(std::string_view geometry_name) const;
    /// What to call a body in text: its name, or "body 17" by its index.
    std::string label(BodyId body) const;

private:
    void play_recording(int frame, bool as_start);
    std::size_t most_changes() const { return size() / 2 + 1024; }
    void note(BodyId body, bool only_pose = false)
    {
        changes.note({index(body) & 0x7fffffffu, only_pose}, most_changes());
    }
    void expect_motion(); ///< of the bodies that have one: makes room
    friend class Mover;

    BodySink* sink_ = nullptr;
    std::size_t passed_ = 0; ///< bodies that the sink was offered
    NameIndex geometry_index_, body_index_;
    PoseColumn starts_;                   ///< of the bodies that were moved
    std::vector<std::uint32_t> start_of_; ///< one more than the place in starts_, 0 for others; may end early
};

/// Hands the bodies of a scene that holds them to a sink, as they are at frame 0.
void pass_bodies(const Scene& scene, BodySink& sink);

/// Why `pose` is not a rigid motion, or an empty text: entries not finite, or a linear part whose R^T R is off the
/// identity by more than 1e-6 or that mirrors.
std::string why_not_rigid(const Eigen::Isometry3d& pose);

/// Moves one body, as Mover does, from its pose at frame `from` to that at `to`; a recording is not asked.
/// @param pose  at `from`; it is read for Jitter alone
void move_body(const Motion& motion, const Eigen::Isometry3d& start, double pace, int from, int to,
               Eigen::Isometry3d& pose);

/// Writes the poses of every moving body at frame `frame` (>= 0). Stateless but for Jitter, which walks on from the
/// frame of the last call (and from the start when time runs backwards). A recording gives the poses of the last whole
/// frame at that time, and throws as Recording::read does. One Mover serves one scene, whose bodies are
/// all there on the first call.
class Mover {
public:
    void move(Scene& scene, int frame);

private:
    int last_frame_ = 0;
    bool ready_ = false;
};

} // namespace oncollide
