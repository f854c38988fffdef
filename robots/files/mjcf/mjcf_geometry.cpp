#include <oncollide/robots/files/mjcf/mjcf_geometry.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

} // namespace

MjcfGeometries::MjcfGeometries(const MjcfDocument& document) : document_(document), source_(document.source())
{
    document.each("asset", [&](const XmlElement& asset) {
        if (asset.name != "mesh") return;
        XmlElement merged = document.with_defaults(asset, "");
        const std::string& own = merged.attribute("name");
        const std::string name = own.empty() ? std::filesystem::path(merged.attribute("file")).stem().string() : own;
        if (name.empty()) source_.fail_at(asset, "has neither a name nor a file");
        if (!meshes_.try_emplace(name, MjcfMesh{std::move(merged)}).second)
            source_.fail_at(asset, fmt::format("there are two meshes {}", oncollide::quoted(name)));
    });
}

/// The mesh of the file, or of the listed vertices: without faces, their convex hull.
GeometryData MjcfGeometries::read_mesh(const XmlElement& element, const std::string& name) const
{
    const Vector3d scale = source_.vector(element, "scale", Vector3d::Ones()),
                   at = source_.vector(element, "refpos", Vector3d::Zero());
    if ((scale.array() == 0).any()) source_.fail_at(element, "a scale of 0 makes the mesh flat");
    const auto quat = source_.numbers(element, "refquat", 4);
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    if (quat) turn = Eigen::Quaterniond((*quat)[0], (*quat)[1], (*quat)[2], (*quat)[3]);
    if (!(turn.coeffs().stableNorm() > 1e-14)) source_.fail_at(element, "refquat has length 0");
    turn.coeffs() = turn.coeffs().stableNormalized();
    const auto placed = [&](std::vector<Vector3d>& vertices) {
        const Eigen::Matrix3d back = turn.conjugate().toRotationMatrix();
        for (Vector3d& v : vertices)
            if (quat || at != Vector3d::Zero()) v = back * (v - at);
    };
    if (!element.attribute("file").empty()) {
        Mesh mesh = load_mesh(document_.mesh_path(element));
        placed(mesh.vertices);
        return scaled(name, std::move(mesh), scale);
    }
    const auto list = source_.numbers(element, "vertex"), corners = source_.numbers(element, "face");
    if (!list) source_.fail_at(element, "has neither a file nor vertices; meshes that MuJoCo makes are not read");
    if (list->size() % 3) source_.fail_at(element, "vertex has numbers besides threes");
    std::vector<Vector3d> vertices;
    for (std::size_t i = 0; i < list->size(); i += 3) vertices.emplace_back((*list)[i], (*list)[i + 1], (*list)[i + 2]);
    placed(vertices);
    if (!corners) {
        for (Vector3d& v : vertices) v = v.cwiseProduct(scale);
        Shape hull = ConvexHull{std::move(vertices)};
        check_shape(name, hull);
        return hull;
    }
    if (corners->size() % 3) source_.fail_at(element, "face has numbers besides threes");
    std::vector<Triangle> triangles(corners->size() / 3);
    for (std::size_t i = 0; i < corners->size(); ++i) {
        const double corner = (*corners)[i];
        if (!(corner >= 0 && corner < double(vertices.size()) && corner == std::floor(corner)))
            source_.fail_at(element, fmt::format("face names vertex {}; the mesh has {}", corner, vertices.size()));
        triangles[i / 3][i % 3] = static_cast<std::uint32_t>(corner);
    }
    return scaled(name, make_mesh(name, std::move(vertices), std::move(triangles)), scale);
}

std::shared_ptr<const Geometry> MjcfGeometries::mesh(const XmlElement& geom)
{
    const std::string& name = source_.required(geom, "mesh");
    const auto found = meshes_.find(name);
    if (found == meshes_.end()) {
        std::vector<std::string_view> names;
        for (const auto& each : meshes_) names.push_back(each.first);
        source_.fail_at(
            geom, fmt::format("there is no mesh {}{}", oncollide::quoted(name), printable(did_you_mean(name, names))));
    }
    auto& [element, geometry] = found->second;
    if (!geometry)
        geometry = source_.at(element, [&] {
            return std::make_shared<const Geometry>(Geometry{name, read_mesh(element, name), {}});
        });
    return geometry;
}

Shape MjcfGeometries::shape(const XmlElement& geom, const std::string& type, Eigen::Isometry3d& pose) const
{
    if (type == "plane") return HalfSpace{};
    const auto listed = source_.numbers(geom, "size");
    std::vector<double> size = listed ? *listed : std::vector<double>();
    const bool is_sphere = type == "sphere", is_round = type == "capsule" || type == "cylinder";
    std::size_t needed = is_sphere ? 1 : is_round ? 2 : 3;
    if (const auto ends = source_.numbers(geom, "fromto", 6); ends && !is_sphere) {
        const Vector3d from(ends->data()), to(ends->data() + 3), along = from - to;
        if (!(along.norm() > 1e-9)) source_.fail_at(geom, "fromto has no length");
        pose.translation() = 0.5 * (from + to), pose.linear() = from_z(along).toRotationMatrix();
        if (size.empty()) source_.fail_at(geom, "has no size");
        size = is_round ? std::vector{size[0], along.norm() / 2} : std::vector{size[0], size[0], along.norm() / 2};
    }
    if (size.size() < needed)
        source_.fail_at(geom, fmt::format("size has {} number{}; a {} has {}", size.size(), size.size() == 1 ? "" : "s",
                                          type, needed));
    for (std::size_t i = 0; i < needed; ++i)
        if (!(size[i] > 0)) source_.fail_at(geom, fmt::format("size is {}; it must be above 0", size[i]));
    if (is_sphere) return Sphere{size[0]};
    if (type == "capsule") return Capsule{size[0], 2 * size[1]};
    if (type == "cylinder") return Cylinder{size[0], 2 * size[1]};
    if (type == "box") return Box{Vector3d(size.data())};
    return Ellipsoid{Vector3d(size.data())};
}

LinkGeometry MjcfGeometries::read(const XmlElement& geom, const std::string& body)
{
    const std::string& given = geom.attribute("type");
    const std::string type = given.empty() ? "sphere" : given;
    LinkGeometry read{{}, document_.pose_of(geom)};
    if (type == "mesh") {
        read.geometry = mesh(geom);
        return read;
    }
    const std::vector<std::string_view> known = {"plane", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"};
    if (type == "hfield" || type == "sdf")
        source_.fail_at(geom, fmt::format("geoms of type {} are not read; use a mesh, or give it contype and "
                                          "conaffinity 0 and add the surface to the environment",
                                          type));
    if (!std::ranges::count(known, type))
        source_.fail_at(geom, fmt::format("unknown type {}{}", oncollide::quoted(type), valid_names(type, known)));
    if (!geom.attribute("mesh").empty())
        source_.fail_at(geom, fmt::format("a {} that is fitted to a mesh is not read; give its size", type));
    Shape solid = shape(geom, type, read.pose);
    source_.at(geom, [&] { check_shape(body, solid); });
    read.geometry = std::make_shared<const Geometry>(Geometry{body, std::move(solid), {}});
    return read;
}

} // namespace oncollide
