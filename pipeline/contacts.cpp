#include <oncollide/pipeline/contacts.hpp>

#include <fmt/format.h>

#include <oncollide/narrowphase/mesh_leaf_test.hpp>
#include <oncollide/pipeline/pair_walks.hpp>
#include <oncollide/scenes/error.hpp>

namespace oncollide {

namespace {

Settings exact_settings()
{
    Settings settings;
    settings.depth = 1; // the exact level goes to a depth of its own
    settings.exact = ExactLevel::predicates;
    return settings;
}

} // namespace

struct ContactFinder::Impl {
    Settings settings = exact_settings();
    Forest forest;
    PairWalks walks{forest};
    MeshLeafTest test;
    Frame frame;
    std::vector<TriangleMeeting> pairs;
    std::vector<Contact> contacts;

    explicit Impl(const Scene& scene)
        : forest(scene, settings, make_cpu_backend()), test(scene, *forest.backend().lists())
    {
        frame.settings = &settings;
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
    p.pairs.clear(), p.contacts.clear();
    const AllMeeting all(p.test, p.pairs);
    PairWalks::Walk walk{{index(a), index(b)}, {}, {}};
    p.frame.trees = {}, p.frame.rounds.clear();
    p.walks.run(scene, p.frame, {&walk, 1}, &all);
    all.finish();
    ++p.frame.number;

    const Eigen::Isometry3d& pose_a = scene.poses[index(a)];
    const IntoA into_a(pose_a, scene.poses[index(b)]);
    const auto corners = [](const Mesh& mesh, std::uint32_t triangle, auto place) {
        const Triangle& t = mesh.triangles[triangle];
        return TrianglePoints{place(mesh.vertices[t[0]]), place(mesh.vertices[t[1]]), place(mesh.vertices[t[2]])};
    };
    for (const TriangleMeeting& pair : p.pairs) {
        const TrianglePoints of_a = corners(mesh_a, pair.a, [](const Eigen::Vector3d& v) { return v; });
        const TrianglePoints of_b = corners(mesh_b, pair.b, into_a);
        const TriangleIntersection where = intersection(of_a, of_b);
        p.contacts.push_back({pair.a,
                              pair.b,
                              triangle_contact(of_a, of_b),
                              {pose_a * where.ends[0], pose_a * where.ends[1]},
                              pose_a.linear() * where.normal_a,
                              pose_a.linear() * where.normal_b});
    }
    return p.contacts;
}

} // namespace oncollide
