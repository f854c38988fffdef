#pragma once
#include <map>
#include <string>

#include <oncollide/robots/files/robot_reader.hpp>

namespace oncollide {

// MJCF, MuJoCo's files of models. Private to robots.

/// An MJCF file with the files that it includes, its compiler's settings and its default classes.
class MjcfDocument {
public:
    /// Throws Error{bad_data}.
    MjcfDocument(RobotSource source, const std::filesystem::path& mjcf);

    const RobotSource& source() const { return source_; }
    const XmlElement& root() const { return root_; }
    /// Calls visit(child) for the children of all sections of that name.
    template <class Visit>
    void each(std::string_view section, Visit visit) const
    {
        for (const XmlElement& part : root_.children)
            if (part.name == section)
                for (const XmlElement& child : part.children) visit(child);
    }

    /// The element without its children, with the attributes that it inherits from its class.
    /// @param childclass  the class of elements that name none; empty: the main one
    XmlElement with_defaults(const XmlElement& element, const std::string& childclass) const;
    /// An angle of the file, in rad.
    double angle(double value) const;
    /// The pose that an element's pos and orientation describe.
    Eigen::Isometry3d pose_of(const XmlElement& element) const;
    std::filesystem::path mesh_path(const XmlElement& mesh) const;

private:
    using Attributes = std::vector<std::pair<std::string, std::string>>;
    struct Class {
        std::map<std::string, Attributes> elements; ///< by the name of an element
    };

    void include_files(XmlElement& element, int level);
    XmlElement read_included(const XmlElement& include);
    void read_compiler();
    void read_class(const XmlElement& element, const Class& parent, bool is_top);
    Eigen::Quaterniond orientation_of(const XmlElement& element) const;

    RobotSource source_;
    const std::filesystem::path folder_;
    XmlElement root_;
    std::filesystem::path meshes_;
    std::string euler_ = "xyz";
    bool is_in_degrees_ = true, strips_paths_ = false;
    std::map<std::string, Class> classes_; ///< the main one has the name ""
};

/// The rotation that takes z to the direction of `to`, by the shortest way.
Eigen::Quaterniond from_z(const Eigen::Vector3d& to);

} // namespace oncollide
