// FCL's geometries. Its headers take seconds to compile: only files that call FCL include this.
#pragma once
#include <memory>
#include <new>
#include <vector>

#include <fcl/fcl.h>

#include <oncollide/scenes/model/convex_hull.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/shape.hpp>

namespace oncollide {

using FclGeometry = std::shared_ptr<fcl::CollisionGeometryd>;

/// A tree over the triangles. Throws std::bad_alloc.
template <class Volume>
FclGeometry make_fcl_tree(const Mesh& mesh)
{
    auto model = std::make_shared<fcl::BVHModel<Volume>>();
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    // If the triangles are valid, only memory can be lacking; a model built regardless would crash.
    const auto made = [](int result) {
        if (result != fcl::BVH_OK) throw std::bad_alloc();
    };
    made(model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(mesh.vertices.size())));
    made(model->addSubModel(mesh.vertices, triangles));
    made(model->endModel());
    return model;
}

/// For std::visit of a Shape.
struct FclShape {
    FclGeometry operator()(const Sphere& s) const { return std::make_shared<fcl::Sphered>(s.radius); }
    FclGeometry operator()(const Box& b) const { return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * b.half)); }
    FclGeometry operator()(const Capsule& c) const { return std::make_shared<fcl::Capsuled>(c.radius, c.length); }
    FclGeometry operator()(const Cylinder& c) const { return std::make_shared<fcl::Cylinderd>(c.radius, c.length); }
    FclGeometry operator()(const Ellipsoid& e) const { return std::make_shared<fcl::Ellipsoidd>(e.semi_axes); }
    FclGeometry operator()(const Cone& c) const { return std::make_shared<fcl::Coned>(c.radius, c.length); }
    FclGeometry operator()(const HalfSpace&) const
    {
        return std::make_shared<fcl::Halfspaced>(fcl::Vector3d::UnitZ(), 0);
    }
    FclGeometry operator()(const ConvexHull& h) const
    {
        const Hull hull = convex_hull(h.points);
        std::vector<int> place(h.points.size(), -1);
        auto points = std::make_shared<std::vector<fcl::Vector3d>>();
        for (std::uint32_t v : hull.vertices) {
            place[v] = static_cast<int>(points->size());
            points->push_back(h.points[v]);
        }
        auto faces = std::make_shared<std::vector<int>>();
        for (const Triangle& t : hull.triangles)
            faces->insert(faces->end(), {3, place[t[0]], place[t[1]], place[t[2]]});
        return std::make_shared<fcl::Convexd>(points, static_cast<int>(hull.triangles.size()), faces);
    }
};

} // namespace oncollide
