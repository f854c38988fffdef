#include <oncollide/pipeline/contacts.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/boxes/traversal.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/pipeline/obb_trees.hpp>

namespace oncollide {

namespace {

/// Unit normals of the triangles of one body, of which most have several contacts.
class Normals {
public:
    void forget() { kept_.fill({}); }
    /// @param place  the triangle's number in its mesh, which is in one pose until forget()
    const Eigen::Vector3d& of(std::uint32_t place, const TrianglePoints& t)
    {
        Kept& kept = kept_[place % kept_.size()];
        if (kept.place != place) kept = {place, unit_normal(t[0], t[1], t[2])};
        return kept.normal;
    }

private:
    struct Kept {
        std::uint32_t place = ~0u;
        Eigen::Vector3d normal{};
    };
    std::array<Kept, 256> kept_;
};

/// One thread's working memory.
struct Worker {
    Traversal walk;
    std::vector<TrianglePair> pairs;
    Normals normals_a, normals_b;
    std::vector<Contact> contacts;

    /// Appends.
    void find(ObbTree& a, ObbTree& b, const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b)
    {
        const RelativePose b_to_a(pose_a, pose_b);
        walk.all_meeting(a, b, b_to_a, pairs);
        normals_a.forget(), normals_b.forget();
        const auto &v = a.mesh().vertices, &w = b.mesh().vertices;
        for (const TrianglePair& pair : pairs) {
            const Triangle &s = a.mesh().triangles[pair.a], &t = b.mesh().triangles[pair.b];
            const TrianglePoints of_a{v[s[0]], v[s[1]], v[s[2]]},
                of_b{b_to_a(w[t[0]]), b_to_a(w[t[1]]), b_to_a(w[t[2]])};
            const auto [ends, kind] = common_segment(of_a, of_b);
            contacts.push_back({pair.a,
                                pair.b,
                                kind,
                                {pose_a * ends[0], pose_a * ends[1]},
                                pose_a.linear() * normals_a.of(pair.a, of_a),
                                pose_a.linear() * normals_b.of(pair.b, of_b)});
        }
    }
};

} // namespace

struct ContactFinder::Impl {
    ObbTrees trees;
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

    ObbTree& tree_of(const Scene& scene, BodyId body) { return trees[scene.geometry[index(body)]]; }

    void admit(const Scene& scene, BodyId body)
    {
        mesh_of(scene, body);
        trees.admit(scene.geometry[index(body)], 0, {~std::uint64_t(0), ~std::size_t(0)});
    }

    void find(const Scene& scene, BodyId a, BodyId b, Worker& worker)
    {
        worker.find(tree_of(scene, a), tree_of(scene, b), scene.poses[index(a)], scene.poses[index(b)]);
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
    if (threads == 1) {
        p.lists.contacts.swap(p.workers.front().contacts);
        for (const Part& part : parts) p.lists.ends.push_back(part.end);
        return p.lists;
    }
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

MeshDistance mesh_distance(const Traversal::Distance& found)
{
    const TrianglePair pair = found.nearest.value_or(TrianglePair{0, 0});
    return {found.lower, found.upper, pair.a, pair.b};
}

MeshDistance ContactFinder::distance(const Scene& scene, BodyId a, BodyId b, double tolerance, double farthest)
{
    Impl& p = *impl_;
    check_distance(tolerance, farthest);
    p.admit(scene, a), p.admit(scene, b);
    const RelativePose b_to_a(scene.poses[index(a)], scene.poses[index(b)]);
    return mesh_distance(
        p.workers.front().walk.distance(p.tree_of(scene, a), p.tree_of(scene, b), b_to_a, tolerance, farthest));
}

} // namespace oncollide
