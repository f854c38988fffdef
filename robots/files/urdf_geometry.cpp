// The collision geometry of URDF files.
#include <oncollide/robots/files/robot_reader.hpp>

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

/// About fixed axes: x, then y, then z.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rpy)
{
    return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
}

} // namespace

Mesh scaled(const std::string& name, Mesh mesh, const Eigen::Vector3d& scale)
{
    for (Eigen::Vector3d& v : mesh.vertices) v = v.cwiseProduct(scale);
    if (scale.prod() < 0)
        for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return make_mesh(name, std::move(mesh.vertices), std::move(mesh.triangles));
}

Eigen::Isometry3d origin_of(const RobotSource& source, const XmlElement& element)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const XmlElement* const origin = element.find("origin");
    if (!origin) return pose;
    constexpr double farthest = 1e15;
    pose.translation() = source.vector(*origin, "xyz", Eigen::Vector3d::Zero());
    if (!(pose.translation().cwiseAbs().maxCoeff() <= farthest)) source.fail_at(*origin, "xyz is beyond 1e15 m");
    const Eigen::Vector3d rpy = source.vector(*origin, "rpy", Eigen::Vector3d::Zero());
    pose.linear() = rotation_of(rpy);
    return pose;
}

fs::path GeometryReader::path_of(const XmlElement& element, const std::string& name) const
{
    // The schemes of ROS and of Gazebo, with one meaning.
    constexpr std::string_view schemes[] = {"package://", "model://"};
    const auto* const scheme =
        std::ranges::find_if(schemes, [&](std::string_view one) { return name.starts_with(one); });
    if (scheme == std::end(schemes)) return source_.at(element, [&] { return file_in(folder_, name); });
    const std::string rest = name.substr(scheme->size());
    const std::string folder = rest.substr(0, rest.find('/'));
    const std::string inside = folder.size() < rest.size() ? rest.substr(folder.size() + 1) : "";
    if (const auto given = reading_.packages.find(folder); given != reading_.packages.end())
        return given->second / inside;
    for (fs::path at = absolute_path(folder_).lexically_normal();; at = at.parent_path()) {
        std::error_code ignored;
        if (at.filename() == folder && fs::exists(at / inside, ignored)) return at / inside;
        if (fs::exists(at / rest, ignored)) return at / rest;
        if (at == at.parent_path()) break;
    }
    source_.fail_at(element, fmt::format("{}: neither the folder of this file nor one above it has that file; name the "
                                         "folder of {} {}",
                                         oncollide::quoted(name), scheme == schemes ? "package" : "model",
                                         oncollide::quoted(folder)));
}

std::shared_ptr<const Geometry> GeometryReader::mesh(const XmlElement& element)
{
    const Eigen::Vector3d scale = source_.vector(element, "scale", Eigen::Vector3d::Ones());
    if ((scale.array() == 0).any()) source_.fail_at(element, "a scale of 0 makes the mesh flat");
    const fs::path path = path_of(element, source_.required(element, "filename"));
    const std::string name = path.string();
    std::shared_ptr<const Geometry>& shared =
        meshes_[fmt::format("{}\n{} {} {}", name, scale.x(), scale.y(), scale.z())];
    if (shared) return shared;
    return shared = source_.at(element, [&] {
        Mesh mesh = load_mesh(path);
        if (scale != Eigen::Vector3d::Ones()) mesh = scaled(name, std::move(mesh), scale);
        return std::make_shared<const Geometry>(Geometry{name, std::move(mesh), {}});
    });
}

LinkGeometry GeometryReader::read(const XmlElement& collision, const std::string& link)
{
    const XmlElement* const geometry = collision.find("geometry");
    if (!geometry) source_.fail_at(collision, fmt::format("of link {}: has no geometry", oncollide::quoted(link)));
    const XmlElement* shape = nullptr;
    for (const XmlElement& child : geometry->children) {
        if (shape) source_.fail_at(*geometry, fmt::format("of link {}: holds two shapes", oncollide::quoted(link)));
        shape = &child;
    }
    if (!shape) source_.fail_at(*geometry, fmt::format("of link {}: is empty", oncollide::quoted(link)));
    LinkGeometry read{{}, origin_of(source_, collision)};
    const auto positive = [&](const char* key) {
        const double value = source_.number(*shape, key);
        if (!(value > 0)) source_.fail_at(*shape, fmt::format("{} is {}; it must be above 0", key, value));
        return value;
    };
    Shape solid;
    if (shape->name == "mesh") {
        read.geometry = mesh(*shape);
        return read;
    } else if (shape->name == "box") {
        source_.required(*shape, "size");
        const Eigen::Vector3d size = source_.vector(*shape, "size", Eigen::Vector3d::Zero());
        if (!(size.array() > 0).all()) source_.fail_at(*shape, "a size is not above 0");
        solid = Box{size / 2};
    } else if (shape->name == "sphere") {
        solid = Sphere{positive("radius")};
    } else if (shape->name == "cylinder") {
        solid = Cylinder{positive("radius"), positive("length")};
    } else if (shape->name == "capsule") {
        solid = Capsule{positive("radius"), positive("length")};
    } else {
        source_.fail_at(*shape,
                        fmt::format("of link {}: an unknown shape; known are box, sphere, cylinder, capsule, mesh",
                                    oncollide::quoted(link)));
    }
    try {
        check_shape(link, solid);
    } catch (const Error& error) {
        source_.fail_at(*shape, error.what());
    }
    read.geometry = std::make_shared<const Geometry>(Geometry{link, std::move(solid), {}});
    return read;
}

} // namespace oncollide
