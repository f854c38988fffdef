#include <oncollide/robots/files/mjcf/mjcf_document.hpp>

#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> orientations = {"axisangle", "xyaxes", "zaxis", "euler"}; // besides quat

/// Whether the reader uses an element, or must refuse it.
bool keep_mjcf(std::string_view name, int)
{
    constexpr std::array<std::string_view, 14> unused = {"actuator",  "camera",   "custom",  "extension", "inertial",
                                                         "light",     "material", "sensor",  "site",      "size",
                                                         "statistic", "tendon",   "texture", "visual"};
    return !std::ranges::count(unused, name);
}

const std::string* find_attribute(const std::vector<std::pair<std::string, std::string>>& list, std::string_view key)
{
    const auto found = std::ranges::find(list, key, &std::pair<std::string, std::string>::first);
    return found == list.end() ? nullptr : &found->second;
}

/// The words of `own`, and the words that `inherited` has beyond their number.
std::string completed(const std::string& own, std::string_view inherited)
{
    constexpr std::string_view blanks = " \t\r\n";
    std::string all = own;
    for (std::size_t at = 0; (at = own.find_first_not_of(blanks, at)) != own.npos; at = own.find_first_of(blanks, at))
        if (const std::size_t begin = inherited.find_first_not_of(blanks); begin != inherited.npos)
            inherited.remove_prefix(std::min(inherited.find_first_of(blanks, begin), inherited.size()));
        else
            return all;
    return all.append(" ").append(inherited);
}

/// Adds inherited attributes to an element's own.
void inherit(std::vector<std::pair<std::string, std::string>>& own,
             const std::vector<std::pair<std::string, std::string>>& inherited)
{
    const bool turned = std::ranges::any_of(orientations, [&](auto key) { return find_attribute(own, key); });
    for (const auto& [key, value] : inherited) {
        const auto mine = std::ranges::find(own, key, &std::pair<std::string, std::string>::first);
        if (mine != own.end()) {
            if (key == "size") mine->second = completed(mine->second, value);
        } else if (!turned || !std::ranges::count(orientations, key)) {
            own.emplace_back(key, value);
        }
    }
}

void set_file(XmlElement& element, std::uint32_t file)
{
    element.file = file;
    for (XmlElement& child : element.children) set_file(child, file);
}

} // namespace

Eigen::Quaterniond from_z(const Eigen::Vector3d& to)
{
    const Eigen::Vector3d unit = to.normalized(), across = Eigen::Vector3d::UnitZ().cross(unit);
    const double sine = across.norm();
    const Eigen::Vector3d axis = sine < 1e-10 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(across / sine);
    return Eigen::Quaterniond(Eigen::AngleAxisd(std::atan2(sine, unit.z()), axis));
}

MjcfDocument::MjcfDocument(RobotSource source, const fs::path& mjcf)
    : source_(std::move(source)), folder_(mjcf.parent_path()), root_(read_xml_elements(source_, keep_mjcf))
{
    if (root_.name != "mujoco") source_.fail_at(root_, "is not MJCF, whose outermost element is 'mujoco'");
    include_files(root_, 0);
    read_compiler();
    const Class none;
    classes_[""];
    for (const XmlElement& section : root_.children)
        if (section.name == "default") read_class(section, none, true);
}

XmlElement MjcfDocument::read_included(const XmlElement& include)
{
    const fs::path path = source_.at(include, [&] { return file_in(folder_, source_.required(include, "file")); });
    const std::string name = path.lexically_normal().string();
    // MuJoCo refuses that, too; it also ends cycles.
    if (name == fs::path(source_.name).lexically_normal().string() || std::ranges::count(source_.included, name))
        source_.fail_at(include, fmt::format("{} is included twice", oncollide::quoted(name)));
    const std::string bytes = source_.at(include, [&] { return read_file(path, std::uintmax_t{64} << 20); });
    XmlElement root = read_xml_elements({name, bytes}, keep_mjcf);
    source_.included.push_back(name);
    set_file(root, static_cast<std::uint32_t>(source_.included.size()));
    return root;
}

/// Replaces each <include> by the contents of its file.
void MjcfDocument::include_files(XmlElement& element, int level)
{
    if (level > XmlReader::most_levels)
        source_.fail_at(element, fmt::format("is deeper than {} levels", XmlReader::most_levels));
    std::vector<XmlElement> children;
    for (XmlElement& child : element.children) {
        if (child.name != "include") {
            include_files(child, level + 1);
            children.push_back(std::move(child));
            continue;
        }
        XmlElement root = read_included(child);
        include_files(root, level + 1);
        std::ranges::move(root.children, std::back_inserter(children));
    }
    element.children = std::move(children);
}

void MjcfDocument::read_compiler()
{
    fs::path assets, meshes;
    for (const XmlElement& element : root_.children) {
        if (element.name != "compiler") continue;
        const auto chosen = [&](const char* key, bool& value, std::string_view yes, std::string_view no) {
            const std::string& text = element.attribute(key);
            if (text.empty()) return;
            if (text != yes && text != no)
                source_.fail_at(element,
                                fmt::format("{} is {}; must be '{}' or '{}'", key, oncollide::quoted(text), yes, no));
            value = text == yes;
        };
        bool is_local = true;
        chosen("angle", is_in_degrees_, "degree", "radian");
        chosen("strippath", strips_paths_, "true", "false");
        chosen("coordinate", is_local, "local", "global");
        if (!is_local)
            source_.fail_at(element, "global coordinates are not read; save the model with MuJoCo before 2.3.3, which "
                                     "makes them local");
        if (const std::string& order = element.attribute("eulerseq"); !order.empty()) {
            if (order.size() != 3 || order.find_first_not_of("xyzXYZ") != order.npos)
                source_.fail_at(element, fmt::format("eulerseq is {}; must be three of the letters x, y, z, X, Y, Z",
                                                     oncollide::quoted(order)));
            euler_ = order;
        }
        const auto folder = [&](const char* key, fs::path& value) {
            if (const std::string& text = element.attribute(key); !text.empty())
                value = source_.at(element, [&] { return file_in(folder_, text); });
        };
        folder("assetdir", assets), folder("meshdir", meshes);
    }
    meshes_ = !meshes.empty() ? meshes : !assets.empty() ? assets : folder_;
}

void MjcfDocument::read_class(const XmlElement& element, const Class& parent, bool is_top)
{
    std::string name = element.attribute("class");
    if (is_top && name == "main") name.clear();
    if (!is_top) source_.required(element, "class");
    if (!is_top && classes_.contains(name))
        source_.fail_at(element, fmt::format("there are two classes {}", oncollide::quoted(name)));
    Class& mine = classes_[is_top ? "" : name];
    if (!is_top) mine = parent;
    for (const XmlElement& child : element.children) {
        if (child.name == "default") continue;
        Attributes own = child.attributes;
        inherit(own, mine.elements[child.name]);
        mine.elements[child.name] = std::move(own);
    }
    for (const XmlElement& child : element.children)
        if (child.name == "default") read_class(child, mine, false);
    if (is_top && !name.empty()) classes_[name] = mine;
}

XmlElement MjcfDocument::with_defaults(const XmlElement& element, const std::string& childclass) const
{
    const std::string &own = element.attribute("class"), &name = own.empty() ? childclass : own;
    const auto found = classes_.find(name == "main" ? "" : name);
    if (found == classes_.end()) {
        std::vector<std::string_view> names;
        for (const auto& each : classes_) names.push_back(each.first);
        source_.fail_at(element, fmt::format("there is no class {}{}", oncollide::quoted(name),
                                             printable(did_you_mean(name, names))));
    }
    XmlElement merged{.name = element.name, .line = element.line, .attributes = element.attributes};
    merged.file = element.file;
    if (const auto inherited = found->second.elements.find(element.name); inherited != found->second.elements.end())
        inherit(merged.attributes, inherited->second);
    return merged;
}

double MjcfDocument::angle(double value) const
{
    return is_in_degrees_ ? value / 180 * std::numbers::pi : value;
}

Eigen::Quaterniond MjcfDocument::orientation_of(const XmlElement& element) const
{
    using Eigen::Vector3d;
    const char* used = nullptr;
    std::vector<double> n;
    for (const std::string_view key : orientations) {
        const bool axis_angle = key == "axisangle", axes = key == "xyaxes";
        const auto found = source_.numbers(element, key, axis_angle ? 4u : axes ? 6u : 3u);
        if (!found) continue;
        if (used) source_.fail_at(element, fmt::format("has two orientations, {} and {}", used, key));
        used = key.data(), n = *found;
    }
    const auto direction = [&](std::size_t from) {
        const Vector3d v(n[from], n[from + 1], n[from + 2]);
        if (!(v.stableNorm() > 1e-14)) source_.fail_at(element, fmt::format("{} has no direction", used));
        return Vector3d(v.stableNormalized());
    };
    const std::string_view is = used ? used : "";
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    if (is == "axisangle") {
        turn = Eigen::AngleAxisd(angle(n[3]), direction(0));
    } else if (is == "xyaxes") {
        const Vector3d x = direction(0), given = direction(3), y = given - x.dot(given) * x;
        if (!(y.norm() > 1e-9)) source_.fail_at(element, "xyaxes are parallel");
        Eigen::Matrix3d axes;
        axes << x, y.normalized(), x.cross(y.normalized());
        turn = axes;
    } else if (is == "zaxis") {
        turn = from_z(direction(0));
    } else if (is == "euler") {
        for (std::size_t i = 0; i < 3; ++i) { // small letters: about axes that turn; capitals: about axes at rest
            const char letter = euler_[i];
            const Vector3d axis = Vector3d::Unit((letter | 0x20) - 'x');
            const Eigen::Quaterniond step(Eigen::AngleAxisd(angle(n[i]), axis));
            turn = letter >= 'x' ? turn * step : step * turn;
        }
    } else if (const auto quat = source_.numbers(element, "quat", 4)) {
        const auto& q = *quat;
        turn = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
        if (!(turn.coeffs().stableNorm() > 1e-14)) source_.fail_at(element, "quat has length 0");
        turn.coeffs() = turn.coeffs().stableNormalized();
    }
    return turn;
}

Eigen::Isometry3d MjcfDocument::pose_of(const XmlElement& element) const
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    constexpr double farthest = 1e15;
    pose.translation() = source_.vector(element, "pos", Eigen::Vector3d::Zero());
    if (!(pose.translation().cwiseAbs().maxCoeff() <= farthest)) source_.fail_at(element, "pos is beyond 1e15 m");
    pose.linear() = orientation_of(element).toRotationMatrix();
    return pose;
}

fs::path MjcfDocument::mesh_path(const XmlElement& mesh) const
{
    const fs::path file = mesh.attribute("file");
    return source_.at(mesh, [&] { return file_in(meshes_, strips_paths_ ? file.filename().string() : file.string()); });
}

} // namespace oncollide
