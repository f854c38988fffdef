// MJCF: bodies, joints and keyframes of MuJoCo's models.
#include <oncollide/robots/files/mjcf/mjcf_geometry.hpp>
#include <oncollide/robots/files/mjcf/mjcf_pairs.hpp>

#include <algorithm>
#include <array>
#include <unordered_set>

#include <fmt/format.h>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

class MjcfReader {
public:
    MjcfReader(RobotSource source, const std::filesystem::path& mjcf)
        : document_(std::move(source), mjcf), source_(document_.source()), geometries_(document_), pairs_(document_)
    {
    }

    RobotDescription read()
    {
        check_sections();
        const XmlElement& root = document_.root();
        robot_.name = root.attribute("model").empty() ? "MuJoCo Model" : root.attribute("model");
        add_link("world", root);
        tree_.bodies.push_back({"world", 0, 0});
        for (const XmlElement& section : root.children)
            if (section.name == "worldbody") read_contents(section, {0, 0, Isometry3d::Identity(), ""});
        robot_.excluded = pairs_.excluded(tree_);
        read_states();
        source_.check(robot_, links_, joints_, document_.root());
        return std::move(robot_);
    }

private:
    /// The body of an element's children, and their frame.
    struct Place {
        std::uint32_t body, link;
        Isometry3d frame; ///< in the body
        std::string childclass;
    };

    void check_sections() const
    {
        const std::vector<std::string_view> known = {"compiler", "option",   "default",  "asset",      "worldbody",
                                                     "contact",  "equality", "keyframe", "deformable", "include"};
        for (const XmlElement& child : document_.root().children)
            if (!std::ranges::count(known, child.name))
                source_.fail_at(child, "is unknown in MJCF" + printable(did_you_mean(child.name, known)));
    }

    std::uint32_t add_link(const std::string& name, const XmlElement& element)
    {
        robot_.links.push_back({unique(link_names_, name), {}});
        links_.push_back(&element), tree_.links.emplace_back();
        return static_cast<std::uint32_t>(robot_.links.size() - 1);
    }
    RobotJoint& add_joint(const std::string& name, const XmlElement& element, std::uint32_t parent, std::uint32_t child)
    {
        robot_.joints.emplace_back();
        joints_.push_back(&element), rest_.emplace_back();
        RobotJoint& joint = robot_.joints.back();
        joint.name = unique(joint_names_, name), joint.parent = parent, joint.child = child;
        return joint;
    }
    static std::string unique(std::unordered_set<std::string>& names, const std::string& name)
    {
        std::string own = name;
        for (int i = 2; !names.insert(own).second; ++i) own = fmt::format("{}#{}", name, i);
        return own;
    }

    /// The geoms and the bodies in a body or a frame.
    void read_contents(const XmlElement& element, const Place& place)
    {
        constexpr std::array<std::string_view, 10> made = {"composite", "flexcomp",   "replicate", "attach", "plugin",
                                                           "flex",      "elasticity", "skin",      "pin",    "edge"};
        for (const XmlElement& child : element.children) {
            if (child.name == "geom")
                read_geom(child, place);
            else if (child.name == "body")
                read_body(child, place);
            else if (child.name == "frame")
                read_contents(child, inside(child, place));
            else if (std::ranges::count(made, child.name))
                source_.fail_at(child, "is not read; let MuJoCo expand the model: 'compile model.xml expanded.xml', or "
                                       "mj_saveLastXML()");
            else if (child.name != "joint" && child.name != "freejoint")
                source_.fail_at(child, "is unknown in a body" +
                                           printable(did_you_mean(child.name, {"body", "geom", "joint", "freejoint",
                                                                               "frame", "inertial", "site"})));
        }
    }
    Place inside(const XmlElement& frame, const Place& place) const
    {
        Place inner = place;
        inner.frame = place.frame * document_.pose_of(frame);
        if (const std::string& name = frame.attribute("childclass"); !name.empty()) inner.childclass = name;
        return inner;
    }

    std::uint32_t mask(const XmlElement& geom, const char* key) const
    {
        const double value = source_.number(geom, key, 1);
        if (!(value >= -0x1p31 && value < 0x1p32 && value == std::floor(value)))
            source_.fail_at(geom, fmt::format("{} is {}; must be a whole number of 32 bits", key, value));
        return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
    }

    void read_geom(const XmlElement& element, const Place& place)
    {
        const XmlElement geom = document_.with_defaults(element, place.childclass);
        const std::string& name = element.attribute("name");
        if (!name.empty() && !geom_names_.insert(name).second)
            source_.fail_at(element, "there are two geoms of this name");
        const bool in_pair = !name.empty() && pairs_.is_in_pair(name);
        const std::uint32_t contype = mask(geom, "contype"), conaffinity = mask(geom, "conaffinity");
        if (!contype && !conaffinity && !in_pair) return; // only to be seen
        LinkGeometry read = geometries_.read(geom, tree_.bodies[place.body].name);
        read.pose = place.frame * read.pose;
        const MjcfTree::GeomLink filter{place.body, contype, conaffinity, in_pair ? name : ""};
        robot_.links[link_for(filter, place, element)].collision.push_back(std::move(read));
    }

    /// The link of the body whose geoms have this filter: the body's own, or one more that is fixed to it.
    std::uint32_t link_for(const MjcfTree::GeomLink& filter, const Place& place, const XmlElement& element)
    {
        const auto fits = [&](std::uint32_t link) {
            const auto& own = tree_.links[link];
            return own && own->contype == filter.contype && own->conaffinity == filter.conaffinity &&
                   own->geom == filter.geom;
        };
        std::vector<std::uint32_t>& links = links_of_[place.body];
        if (links.empty()) links.push_back(place.link), tree_.links[place.link] = filter;
        const auto found = std::ranges::find_if(links, fits);
        if (found != links.end()) return *found;
        const std::string& body = tree_.bodies[place.body].name;
        const std::uint32_t link = add_link(filter.geom.empty() ? body + "/geoms" : body + "/" + filter.geom, element);
        add_joint(robot_.links[link].name + "/fixed", element, place.link, link);
        tree_.links[link] = filter, links.push_back(link);
        return link;
    }

    struct PlacedJoint {
        const XmlElement* element;
        Isometry3d frame;
        std::string childclass;
    };
    void find_joints(const XmlElement& element, const Place& place, std::vector<PlacedJoint>& joints) const
    {
        for (const XmlElement& child : element.children)
            if (child.name == "joint" || child.name == "freejoint")
                joints.push_back({&child, place.frame, place.childclass});
            else if (child.name == "frame")
                find_joints(child, inside(child, place), joints);
    }

    void read_body(const XmlElement& element, const Place& place)
    {
        const auto number = static_cast<std::uint32_t>(tree_.bodies.size());
        const std::string& given = element.attribute("name");
        const std::string name = given.empty() ? fmt::format("body {}", number) : given;
        if (!body_names_.insert(name).second || name == "world")
            source_.fail_at(element, "there are two bodies of this name");
        Place own{number, 0, Isometry3d::Identity(), place.childclass};
        if (const std::string& childclass = element.attribute("childclass"); !childclass.empty())
            own.childclass = childclass;
        std::vector<PlacedJoint> joints;
        find_joints(element, own, joints);
        tree_.bodies.push_back({name, place.body, joints.empty() ? tree_.bodies[place.body].weld : number});

        std::uint32_t at = place.link;
        Isometry3d from = place.frame * document_.pose_of(element);
        for (const PlacedJoint& joint : joints) {
            const bool is_last = &joint == &joints.back();
            at = read_joint(joint, name, is_last, joints.size() == 1, at, from);
        }
        // The link's frame is the body's, also where the last joint turns about another point.
        if (joints.empty() || !(from.matrix() == Eigen::Matrix4d::Identity())) {
            const std::uint32_t link = add_link(name, element);
            add_joint(name + "/fixed", element, at, link).origin = from;
            at = link;
        }
        own.link = at;
        read_contents(element, own);
    }

    /// Adds a joint below link `at`, and the link that it moves. Sets `from`: the body's frame in that link.
    std::uint32_t read_joint(const PlacedJoint& placed, const std::string& body, bool is_last, bool is_only,
                             std::uint32_t at, Isometry3d& from)
    {
        const XmlElement& element = *placed.element;
        const XmlElement joint =
            element.name == "freejoint" ? element : document_.with_defaults(element, placed.childclass);
        const std::string& given = joint.attribute("type");
        const std::string type = element.name == "freejoint" ? "free" : given.empty() ? "hinge" : given;
        if (type == "ball")
            source_.fail_at(element,
                            "a ball joint is not a kind of joint of a Robot; write three hinges about x, y and "
                            "z at its place");
        const std::vector<std::string_view> types = {"hinge", "slide", "free", "ball"};
        if (!std::ranges::count(types, type))
            source_.fail_at(element,
                            fmt::format("unknown type {}{}", oncollide::quoted(type), valid_names(type, types)));
        const std::string& name = element.attribute("name");
        if (!name.empty() && joint_names_.contains(name)) source_.fail_at(element, "there are two joints of this name");
        const std::uint32_t parent = at;
        const auto add = [&](Isometry3d origin, const Vector3d& anchor) -> RobotJoint& {
            from = Isometry3d(Eigen::Translation3d(-anchor));
            const bool has_body_frame = is_last && anchor == Vector3d::Zero();
            const std::string own = name.empty() ? body + "/joint" : name;
            at = add_link(has_body_frame ? body : body + "/" + own, element);
            RobotJoint& made = add_joint(own, element, parent, at);
            made.origin = origin;
            return made;
        };
        if (type == "free") {
            if (!is_only || parent != 0)
                source_.fail_at(element, "a free joint must be the only one of a body in the world");
            const Eigen::Quaterniond turn(from.linear());
            const Vector3d place = from.translation();
            add(Isometry3d::Identity(), Vector3d::Zero()).kind = JointKind::floating;
            rest_.back() = {place.x(), place.y(), place.z(), turn.x(), turn.y(), turn.z(), turn.w()};
            return at;
        }
        const bool turns = type == "hinge";
        const Vector3d along = placed.frame.linear() * source_.vector(joint, "axis", Vector3d::UnitZ());
        const double length = along.stableNorm();
        if (!(length > 1e-9 && length < 1e9)) source_.fail_at(element, "its axis has no direction");
        const Vector3d axis = along / length, zero = Vector3d::Zero(),
                       anchor = turns ? Vector3d(placed.frame * source_.vector(joint, "pos", zero)) : zero;
        const auto measure = [&](double value) { return turns ? document_.angle(value) : value; };
        const double rest = measure(source_.number(joint, "ref", 0)); // the number at the pose of the file
        Isometry3d origin = from * Eigen::Translation3d(anchor);
        if (rest != 0 && turns) origin.rotate(Eigen::AngleAxisd(-rest, axis));
        if (rest != 0 && !turns) origin.translate(-rest * axis);
        RobotJoint& made = add(origin, anchor);
        made.axis = axis, rest_.back() = {rest};
        const auto range = source_.numbers(joint, "range", 2);
        const std::string& limited = joint.attribute("limited");
        const bool has_limits = range && limited != "false" && (limited == "true" || (*range)[0] < (*range)[1]);
        if (has_limits) made.lower = measure((*range)[0]), made.upper = measure((*range)[1]);
        made.kind = !turns ? JointKind::prismatic : has_limits ? JointKind::revolute : JointKind::continuous;
        return at;
    }

    /// The pose of the file is the state "qpos0", as MuJoCo calls it; keyframes are states of their names.
    void read_states()
    {
        const auto state_of = [&](const std::string& name, const std::vector<double>& qpos) {
            RobotState state{name, "", {}};
            std::size_t at = 0;
            for (std::uint32_t i = 0; i < robot_.joints.size(); ++i)
                if (const std::size_t count = rest_[i].size()) {
                    state.values.push_back(
                        {i, {qpos.begin() + std::ptrdiff_t(at), qpos.begin() + std::ptrdiff_t(at + count)}});
                    at += count;
                }
            robot_.states.push_back(std::move(state));
        };
        std::vector<double> all;
        for (const std::vector<double>& numbers : rest_) all.insert(all.end(), numbers.begin(), numbers.end());
        if (!all.empty()) state_of("qpos0", all);
        document_.each("keyframe", [&](const XmlElement& key) {
            const auto given = source_.numbers(key, "qpos");
            if (!given) return;
            if (given->size() != all.size())
                source_.fail_at(key, fmt::format("qpos has {} numbers; the joints have {}", given->size(), all.size()));
            std::vector<double> qpos = *given;
            std::size_t at = 0;
            for (const std::vector<double>& numbers : rest_) {
                if (numbers.size() == 7) { // MuJoCo's quaternions begin with w
                    Eigen::Quaterniond turn(qpos[at + 3], qpos[at + 4], qpos[at + 5], qpos[at + 6]);
                    if (!(turn.coeffs().stableNorm() > 1e-14)) source_.fail_at(key, "a quaternion has length 0");
                    const Eigen::Vector4d unit = turn.coeffs().stableNormalized();
                    std::ranges::copy(unit, qpos.begin() + std::ptrdiff_t(at + 3));
                }
                at += numbers.size();
            }
            const std::string& name = key.attribute("name");
            state_of(name.empty() ? fmt::format("key {}", robot_.states.size() - 1) : name, qpos);
        });
    }

    const MjcfDocument document_;
    const RobotSource& source_;
    MjcfGeometries geometries_;
    const MjcfPairs pairs_;
    RobotDescription robot_;
    MjcfTree tree_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> links_of_; ///< by body: links with its geoms
    std::vector<const XmlElement*> links_, joints_;                ///< as in robot_
    std::vector<std::vector<double>> rest_;                        ///< by joint: its numbers in the file's pose
    std::unordered_set<std::string> link_names_, joint_names_, body_names_, geom_names_;
};

} // namespace

RobotDescription read_mjcf(RobotSource source, const std::filesystem::path& mjcf)
{
    return MjcfReader(std::move(source), mjcf).read();
}

} // namespace oncollide
