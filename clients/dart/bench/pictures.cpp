#include "pictures.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <variant>

#include <dart/dynamics/BoxShape.hpp>

#include <oncollide/samples/generators.hpp>

#include "../geometry_of_shape.hpp"
#include "render/flat_picture.hpp"
#include "render/png.hpp"

namespace dart::collision::oncollide_client::bench {

using Eigen::Vector3d;

namespace {

oncollide::Mesh mesh_to_draw(const dynamics::Shape& shape)
{
    if (const auto* box = dynamic_cast<const dynamics::BoxShape*>(&shape))
        return oncollide::make_box_mesh(box->getSize() / 2);
    const PlacedGeometry placed = geometry_of(shape, false);
    const auto* mesh = placed.geometry ? std::get_if<oncollide::Mesh>(&placed.geometry->data) : nullptr;
    if (!mesh) throw std::runtime_error("pictures: no mesh for a " + shape.getType());
    return *mesh;
}

oncollide::Colour colour_of(std::size_t number)
{
    static constexpr std::array<oncollide::Colour, 6> colours{
        {{86, 140, 214}, {236, 178, 84}, {110, 186, 126}, {178, 132, 200}, {122, 196, 204}, {214, 150, 150}}};
    return colours[number % colours.size()];
}

/// Leaves only triangles that face away from the camera.
void keep_far_side(oncollide::Mesh& mesh, const Eigen::Isometry3d& pose)
{
    const Vector3d to_eye(0.4, -1, 0.5); // as Framing looks, nearly
    std::erase_if(mesh.triangles, [&](const oncollide::Triangle& t) {
        const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        return (pose.linear() * (b - a).cross(c - a)).dot(to_eye) > 0;
    });
}

} // namespace

void View::add(const dynamics::Shape& shape, const Eigen::Isometry3d& pose, Role role)
{
    if (!pose.matrix().allFinite()) return;
    oncollide::Mesh& mesh = *meshes_.emplace_back(std::make_shared<oncollide::Mesh>(mesh_to_draw(shape)));
    if (role == Role::glass) keep_far_side(mesh, pose);
    if (role != Role::fixed)
        for (const Vector3d& v : mesh.vertices) to_see_.push_back(pose * v);
    const oncollide::Colour grey{214, 214, 210};
    picture_.bodies.push_back({&mesh, pose, role == Role::moving ? colour_of(moving_++) : grey});
}

void View::add(const CollisionResult& contacts)
{
    oncollide::Aabb box;
    for (const Vector3d& p : to_see_) box.add(p);
    meshes_.push_back(std::make_shared<oncollide::Mesh>(oncollide::make_sphere_mesh(0.012 * box.diagonal(), 32)));
    for (const Contact& contact : contacts.getContacts())
        picture_.bodies.push_back(
            {meshes_.back().get(), Eigen::Isometry3d(Eigen::Translation3d(contact.point)), {214, 30, 30}});
}

void save_pictures(const std::filesystem::path& path, const std::vector<View>& views)
{
    constexpr int side = 260;
    oncollide::tools::Framing framing(side, side);
    for (const Vector3d& p : views.back().to_see_) framing.add(p, 0);
    oncollide::tools::Image image = oncollide::tools::blank(side * static_cast<int>(views.size()), side);
    for (std::size_t i = 0; i < views.size(); ++i) {
        oncollide::Picture picture = views[i].picture_;
        picture.camera = framing.camera(), picture.width = picture.height = side;
        paste(oncollide::tools::draw_bodies(picture).pixels, side, image, side * static_cast<int>(i));
    }
    save_png(image, path);
}

} // namespace dart::collision::oncollide_client::bench
