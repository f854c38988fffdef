#include <oncollide/pipeline/contacts.hpp>

#include <fmt/format.h>

#include <oncollide/narrowphase/triangle_walk.hpp>
#include <oncollide/pipeline/triangle_trees.hpp>
#include <oncollide/scenes/error.hpp>

namespace oncollide {

struct ContactFinder::Impl {
    TriangleTrees trees;
    TriangleWalk walk;
    std::vector<TriangleMeeting> pairs;
    std::vector<Contact> contacts;

    explicit Impl(const Scene& scene) : trees(scene) {}

    TriangleTree& tree_of(const Scene& scene, BodyId body)
    {
        const GeometryId geometry = scene.geometry[index(body)];
        trees.admit(geometry, 0, {~std::uint64_t(0), ~std::size_t(0)});
        return trees[geometry];
    }

    static const Mesh& mesh_of(const Scene& scene, BodyId body)
    {
        if (index(body) >= scene.size())
            throw Error(ErrorKind::usage, fmt::format("contacts: there is no body {}", index(body)));
        const auto* mesh = std::get_if<Mesh>(&scene.geometries[index(scene.geometry[index(body)])].data);
        if (!mesh)
            throw Error(ErrorKind::usage, fmt::format("contacts: body '{}' is no mesh", scene.names[index(body)]));
        return *mesh;
    }
};

ContactFinder::ContactFinder(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;

const std::vector<Contact>& ContactFinder::find(const Scene& scene, BodyId a, BodyId b)
{
    Impl& p = *impl_;
    const Mesh &mesh_a = Impl::mesh_of(scene, a), &mesh_b = Impl::mesh_of(scene, b);
    const Eigen::Isometry3d& pose_a = scene.poses[index(a)];
    const IntoA into_a(pose_a, scene.poses[index(b)]);
    p.walk.all_meeting(p.tree_of(scene, a), p.tree_of(scene, b), into_a, p.pairs);

    p.contacts.clear();
    const auto corners = [](const Mesh& mesh, std::uint32_t triangle, auto place) {
        const Triangle& t = mesh.triangles[triangle];
        return TrianglePoints{place(mesh.vertices[t[0]]), place(mesh.vertices[t[1]]), place(mesh.vertices[t[2]])};
    };
    for (const TriangleMeeting& pair : p.pairs) {
        const TrianglePoints in_a = corners(mesh_a, pair.a, [](const Eigen::Vector3d& v) { return v; });
        const TrianglePoints in_b = corners(mesh_b, pair.b, into_a);
        const TriangleIntersection where = intersection(in_a, in_b);
        p.contacts.push_back({pair.a,
                              pair.b,
                              triangle_contact(in_a, in_b),
                              {pose_a * where.ends[0], pose_a * where.ends[1]},
                              pose_a.linear() * where.normal_a,
                              pose_a.linear() * where.normal_b});
    }
    return p.contacts;
}

void check_distance(double tolerance, double farthest)
{
    for (const auto& [what, value] : {std::pair("tolerance", tolerance), std::pair("limit", farthest)})
        if (!(value >= 0))
            throw Error(ErrorKind::usage, fmt::format("distance: a {} of {}; must be 0 or more", what, value));
}

MeshDistance mesh_distance(const TriangleWalk::Distance& found)
{
    const TriangleMeeting pair = found.nearest.value_or(TriangleMeeting{0, 0});
    return {found.lower, found.upper, pair.a, pair.b};
}

MeshDistance ContactFinder::distance(const Scene& scene, BodyId a, BodyId b, double tolerance, double farthest)
{
    Impl& p = *impl_;
    for (BodyId body : {a, b}) Impl::mesh_of(scene, body);
    check_distance(tolerance, farthest);
    const IntoA into_a(scene.poses[index(a)], scene.poses[index(b)]);
    return mesh_distance(p.walk.distance(p.tree_of(scene, a), p.tree_of(scene, b), into_a, tolerance, farthest));
}

} // namespace oncollide
