#pragma once
#include <map>
#include <memory>
#include <string>

#include <oncollide/robots/files/mjcf/mjcf_document.hpp>

namespace oncollide {

/// Reads geoms. Geoms of one mesh share it; meshes that no such geom names are not read.
class MjcfGeometries {
public:
    explicit MjcfGeometries(const MjcfDocument& document);
    /// @param geom  with the attributes that it inherits
    /// @param body  its body's name
    LinkGeometry read(const XmlElement& geom, const std::string& body);

private:
    struct MjcfMesh {
        XmlElement element; ///< with the attributes that it inherits
        std::shared_ptr<const Geometry> geometry{};
    };
    std::shared_ptr<const Geometry> mesh(const XmlElement& geom);
    GeometryData read_mesh(const XmlElement& element, const std::string& name) const;
    Shape shape(const XmlElement& geom, const std::string& type, Eigen::Isometry3d& pose) const;

    const MjcfDocument& document_;
    const RobotSource& source_;
    std::map<std::string, MjcfMesh> meshes_;
};

} // namespace oncollide
