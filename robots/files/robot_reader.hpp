#pragma once
#include <map>
#include <optional>
#include <span>
#include <string>

#include <oncollide/robots/robot.hpp>
#include <oncollide/scenes/files/xml/xml_element.hpp>

namespace oncollide {

// Shared by the readers of URDF, SRDF and MJCF.

/// A file whose faults name a line and an element.
struct RobotSource : MeshSource {
    /// The names of the files that XmlElement::file means, from 1 on.
    std::vector<std::string> included{};

    /// Throws Error{bad_data} with the message "FILE: line N: joint 'a': TEXT".
    [[noreturn]] void fail_at(const XmlElement& element, const std::string& text) const;
    /// Returns work(). Its errors name the element, except Error{usage}.
    template <class Work>
    auto at(const XmlElement& element, Work work) const
    {
        try {
            return work();
        } catch (const Error& error) {
            if (error.kind() == ErrorKind::usage) throw;
            fail_at(element, error.what());
        }
    }
    /// Throws Error{bad_data} for the fault of fault_of(), at its element.
    /// @param links, joints  the elements of the robot's links and joints
    /// @param root           the element of everything else
    void check(const RobotDescription& robot, std::span<const XmlElement* const> links,
               std::span<const XmlElement* const> joints, const XmlElement& root) const;
    /// An attribute that must be there, and must not be empty.
    const std::string& required(const XmlElement& element, std::string_view key) const;
    /// The finite numbers of an attribute; nothing if it is absent. Throws unless there are `count`.
    std::optional<std::vector<double>> numbers(const XmlElement& element, std::string_view key,
                                               std::size_t count) const;
    std::optional<std::vector<double>> numbers(const XmlElement& element, std::string_view key) const; ///< any count
    double number(const XmlElement& element, std::string_view key) const; ///< one that must be there
    double number(const XmlElement& element, std::string_view key, double without) const;
    Eigen::Vector3d vector(const XmlElement& element, std::string_view key, const Eigen::Vector3d& without) const;
};

/// The number of the link or joint of this name. Throws Error{bad_data} that names similar ones.
/// @param what  "link" or "joint"
template <class Named>
std::uint32_t find_named(const RobotSource& source, const XmlElement& element, const char* what, std::string_view name,
                         const std::vector<Named>& named);
extern template std::uint32_t find_named(const RobotSource&, const XmlElement&, const char*, std::string_view,
                                         const std::vector<RobotLink>&);
extern template std::uint32_t find_named(const RobotSource&, const XmlElement&, const char*, std::string_view,
                                         const std::vector<RobotJoint>&);

/// Reads <geometry> elements. Links share meshes of one file and scale.
class GeometryReader {
public:
    GeometryReader(const RobotSource& source, const std::filesystem::path& urdf, const RobotReading& reading)
        : source_(source), folder_(urdf.parent_path()), reading_(reading)
    {
    }
    LinkGeometry read(const XmlElement& collision, const std::string& link);

private:
    std::shared_ptr<const Geometry> mesh(const XmlElement& element);
    std::filesystem::path path_of(const XmlElement& element, const std::string& name) const;

    const RobotSource& source_;
    const std::filesystem::path folder_;
    const RobotReading& reading_;
    std::map<std::string, std::shared_ptr<const Geometry>> meshes_; ///< by path and scale
};

/// The pose of the element's <origin>; the identity without one.
Eigen::Isometry3d origin_of(const RobotSource& source, const XmlElement& element);

/// Each axis by its own factor. An odd number of negative factors mirrors, which turns the triangles over.
Mesh scaled(const std::string& name, Mesh mesh, const Eigen::Vector3d& scale);

RobotDescription read_urdf(const RobotSource& source, const std::filesystem::path& urdf, const RobotReading& reading);
/// Adds the excluded pairs, groups and states.
void read_srdf(const RobotSource& source, RobotDescription& robot);
RobotDescription read_mjcf(RobotSource source, const std::filesystem::path& mjcf);

} // namespace oncollide
