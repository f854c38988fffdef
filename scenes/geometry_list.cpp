#include <algorithm>
#include <cstring>

#include <oncollide/scenes/columns.hpp>
#include <oncollide/scenes/deformation.hpp>

namespace oncollide {

const GeometryList::Rest* GeometryList::rest_of(std::size_t i) const
{
    const auto at = std::ranges::lower_bound(deforming_, i);
    return at != deforming_.end() && *at == i ? &rest_[std::size_t(at - deforming_.begin())] : nullptr;
}

const Deformation* GeometryList::deformation(std::size_t i) const
{
    const Rest* const rest = rest_of(i);
    return rest ? rest->deformation.get() : nullptr;
}

const Geometry& GeometryList::at_rest(std::size_t i) const
{
    const Rest* const rest = rest_of(i);
    return rest ? *rest->geometry : *items_[i];
}

std::shared_ptr<const Geometry> GeometryList::at_time(const Rest& rest, const std::shared_ptr<const Geometry>& before,
                                                      double time)
{
    const Mesh& mesh = std::get<Mesh>(rest.geometry->data);
    std::vector<Eigen::Vector3d> vertices(mesh.vertices.size());
    rest.deformation->move(mesh, time, vertices);
    const bool same = std::memcmp(vertices.data(), std::get<Mesh>(before->data).vertices.data(),
                                  vertices.size() * sizeof(vertices[0])) == 0;
    if (same) return before;
    return std::make_shared<const Geometry>(
        Geometry{before->name, make_mesh(before->name, std::move(vertices), mesh.triangles), {}});
}

void GeometryList::deform(double time)
{
    std::vector<std::shared_ptr<const Geometry>> now;
    for (std::size_t k = 0; k < deforming_.size(); ++k) now.push_back(at_time(rest_[k], items_[deforming_[k]], time));
    for (std::size_t k = 0; k < now.size(); ++k) items_[deforming_[k]] = std::move(now[k]);
}

} // namespace oncollide
