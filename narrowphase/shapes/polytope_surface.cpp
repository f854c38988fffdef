#include <oncollide/narrowphase/shapes/polytope_surface.hpp>

#include <limits>

#include <oncollide/narrowphase/shapes/convex_surface.hpp>
#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

constexpr auto not_yet = std::numeric_limits<std::uint32_t>::max();

struct Core {
    Mesh operator()(const Box& b) const { return box_mesh(b.half); }
    Mesh operator()(const ConvexHull& h) const
    {
        std::vector<Triangle> faces = convex_surface(h.points);
        std::vector<Eigen::Vector3d> corners;
        std::vector<std::uint32_t> place(h.points.size(), not_yet);
        for (Triangle& face : faces)
            for (std::uint32_t& v : face) {
                if (place[v] == not_yet)
                    place[v] = static_cast<std::uint32_t>(corners.size()), corners.push_back(h.points[v]);
                v = place[v];
            }
        return make_mesh("convex hull", std::move(corners), std::move(faces));
    }
    Mesh operator()(const auto&) const { return {}; } // round shapes
};

} // namespace

Mesh surface_of_polytope(const Shape& shape)
{
    return std::visit(Core{}, shape);
}

} // namespace oncollide
