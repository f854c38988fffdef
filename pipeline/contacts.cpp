#include <oncollide/pipeline/contacts.hpp>

#include <fmt/format.h>

#include <oncollide/narrowphase/triangle_walk.hpp>
#include <oncollide/pipeline/triangle_trees.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

/// One thread's working memory.
struct Worker {
    TriangleWalk walk;
    std::vector<TriangleMeeting> pairs;
    std::vector<Contact> contacts;
};

Contact contact_of(TriangleMeeting pair, const Mesh& mesh_a, const Mesh& mesh_b, const Eigen::Isometry3d& pose_a,
                   const IntoA& into_a)
{
    const Triangle &s = mesh_a.triangles[pair.a], &t = mesh_b.triangles[pair.b];
    const auto &v = mesh_a.vertices, &w = mesh_b.vertices;
    const TrianglePoints of_a{v[s[0]], v[s[1]], v[s[2]]}, of_b{into_a(w[t[0]]), into_a(w[t[1]]), into_a(w[t[2]])};
    const TriangleIntersection where = intersection(of_a, of_b);
    return {pair.a,
            pair.b,
            triangle_contact(of_a, of_b),
            {pose_a * where.ends[0], pose_a * where.ends[1]},
            pose_a.linear() * where.normal_a,
            pose_a.linear() * where.normal_b};
}

} // namespace

struct ContactFinder::Impl {
    TriangleTrees trees;
    std::vector<Worker> workers{1};
    ContactLists lists;

    explicit Impl(const Scene& scene) : trees(scene) {}

    static const Mesh& mesh_of(const Scene& scene, BodyId body)
    {
        if (index(body) >= scene.size())
            throw Error(ErrorKind::usage, fmt::format("contacts: there is no body {}", index(body)));
        const auto* mesh = std::get_if<Mesh>(&scene.geometries[index(scene.geometry[index(body)])].data);
        if (!mesh)
            throw Error(ErrorKind::usage, fmt::format("contacts: body '{}' is no mesh", scene.names[index(body)]));
        return *mesh;
    }

    TriangleTree& tree_of(const Scene& scene, BodyId body) { return trees[scene.geometry[index(body)]]; }

    void admit(const Scene& scene, BodyId body)
    {
        mesh_of(scene, body);
        trees.admit(scene.geometry[index(body)], 0, {~std::uint64_t(0), ~std::size_t(0)});
    }

    /// Appends.
    void find(const Scene& scene, BodyId a, BodyId b, Worker& worker)
    {
        const Eigen::Isometry3d& pose_a = scene.poses[index(a)];
        const IntoA into_a(pose_a, scene.poses[index(b)]);
        worker.walk.all_meeting(tree_of(scene, a), tree_of(scene, b), into_a, worker.pairs);
        for (const TriangleMeeting& pair : worker.pairs)
            worker.contacts.push_back(contact_of(pair, mesh_of(scene, a), mesh_of(scene, b), pose_a, into_a));
    }
};

ContactFinder::ContactFinder(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;

const std::vector<Contact>& ContactFinder::find(const Scene& scene, BodyId a, BodyId b)
{
    Impl& p = *impl_;
    p.admit(scene, a), p.admit(scene, b);
    Worker& worker = p.workers.front();
    worker.contacts.clear();
    p.find(scene, a, b, worker);
    return worker.contacts;
}

const ContactLists& ContactFinder::find_all(const Scene& scene, std::span<const BodyPair> pairs, int threads)
{
    Impl& p = *impl_;
    for (const BodyPair& pair : pairs) p.admit(scene, BodyId{pair.a}), p.admit(scene, BodyId{pair.b});
    if (threads == 0) threads = hardware_threads();
    while (p.workers.size() < static_cast<std::size_t>(threads)) p.workers.emplace_back();
    for (Worker& worker : p.workers) worker.contacts.clear();

    struct Part {
        std::size_t worker, begin, end;
    };
    std::vector<Part> parts(pairs.size());
    parallel_chunks(pairs.size(), 16, threads, [&](std::size_t begin, std::size_t end, int thread) {
        const auto number = static_cast<std::size_t>(thread);
        Worker& worker = p.workers[number];
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t first = worker.contacts.size();
            p.find(scene, BodyId{pairs[i].a}, BodyId{pairs[i].b}, worker);
            parts[i] = {number, first, worker.contacts.size()};
        }
    });
    p.lists.contacts.clear(), p.lists.ends.clear();
    for (const Part& part : parts) {
        const auto from = p.workers[part.worker].contacts.begin();
        p.lists.contacts.insert(p.lists.contacts.end(), from + static_cast<std::ptrdiff_t>(part.begin),
                                from + static_cast<std::ptrdiff_t>(part.end));
        p.lists.ends.push_back(p.lists.contacts.size());
    }
    return p.lists;
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
    check_distance(tolerance, farthest);
    p.admit(scene, a), p.admit(scene, b);
    const IntoA into_a(scene.poses[index(a)], scene.poses[index(b)]);
    return mesh_distance(p.workers.front().walk.distance(p.tree_of(scene, a), p.tree_of(scene, b), into_a, tolerance, farthest));
}

} // namespace oncollide
