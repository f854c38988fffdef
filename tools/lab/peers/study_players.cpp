// The libraries that play a study and support triangles alone.
#include "peers/study_players.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include <oncollide/broadphase/bounds/pose_bounds.hpp>

#include "cli/system.hpp"
#include "common/text.hpp"
#include "peers/peers.hpp"

namespace oncollide::tools {
namespace {

constexpr std::size_t most_structures = 100;

/// Two geometries, first <= second.
using GeometryPair = std::pair<std::uint32_t, std::uint32_t>;

/// Pairs of geometries whose bodies can collide: at least one of the two bodies is dynamic.
std::vector<GeometryPair> geometry_pairs(const Scene& scene)
{
    std::vector<std::uint32_t> bodies(scene.geometries.size()), movers(bodies.size());
    for (std::uint32_t body = 0; body < scene.size(); ++body)
        ++bodies[index(scene.geometry[body])], movers[index(scene.geometry[body])] += !scene.is_static[body];
    std::vector<GeometryPair> pairs;
    for (std::uint32_t g = 0; g < bodies.size(); ++g)
        for (std::uint32_t h = g; h < bodies.size(); ++h)
            if (bodies[g] && bodies[h] && movers[g] + movers[h] && (g != h || bodies[g] > 1)) pairs.emplace_back(g, h);
    return pairs;
}

const Mesh& mesh_of(const Scene& scene, std::uint32_t geometry)
{
    return std::get<Mesh>(scene.geometries[geometry].data);
}

template <class Kind>
const Kind& contender(const ContenderList<Kind>& list, const std::string& name)
{
    return *std::ranges::find(list.all, name, &Kind::name);
}

class MeshPlayer final : public StudyPlayer {
public:
    MeshPlayer(const Scene& scene, const NarrowContender& narrow, const BroadContender* broad)
        : scene_(scene), peers_(scene.geometries.size() * scene.geometries.size()), boxes_(scene.size())
    {
        for (const Geometry& geometry : scene.geometries) bounds_.emplace_back(geometry.data);
        for (const auto& [g, h] : geometry_pairs(scene)) peer(g, h) = narrow.make(mesh_of(scene, g), mesh_of(scene, h));
        if (!broad) return;
        broad_ = broad->make(1);
        std::vector<std::uint32_t> all(scene.size());
        std::iota(all.begin(), all.end(), 0u);
        std::ranges::copy_if(all, std::back_inserter(moving_), [&](std::uint32_t b) { return !scene.is_static[b]; });
        update_boxes(all);
        broad_->start(frame());
    }

    Result step() override
    {
        const Clock::time_point from = Clock::now();
        find_candidates();
        Result result;
        result.candidates = candidates_.size();
        for (BodyPair pair : candidates_)
            if (collide(pair)) result.colliding.push_back({std::min(pair.a, pair.b), std::max(pair.a, pair.b)});
        result.ms = milliseconds_since(from);
        std::ranges::sort(result.colliding);
        return result;
    }

    std::size_t bytes() const override { return bytes_; }
    void set_bytes(std::size_t bytes) { bytes_ = bytes; }

private:
    std::unique_ptr<NarrowPeer>& peer(std::uint32_t g, std::uint32_t h)
    {
        return peers_[g * scene_.geometries.size() + h];
    }

    BoxFrame frame() const { return {boxes_, moving_, scene_.is_static}; }

    void update_boxes(std::span<const std::uint32_t> bodies)
    {
        for (std::uint32_t body : bodies) bounds_[index(scene_.geometry[body])].expect(scene_.poses[body]);
        for (std::uint32_t body : bodies) boxes_[body] = bounds_[index(scene_.geometry[body])].box(scene_.poses[body]);
    }

    void find_candidates()
    {
        if (!broad_) {
            candidates_ = {{0, 1}};
            return;
        }
        update_boxes(moving_);
        broad_->step(frame(), candidates_);
        const BodyColumns filter{boxes_, scene_.layers, scene_.masks};
        std::erase_if(candidates_, [&](BodyPair pair) { return !filter.allows(pair.a, pair.b); });
    }

    bool collide(BodyPair pair)
    {
        std::uint32_t a = pair.a, b = pair.b;
        if (scene_.geometry[b] < scene_.geometry[a]) std::swap(a, b);
        return peer(index(scene_.geometry[a]), index(scene_.geometry[b]))
            ->collides(scene_.poses[a].inverse(Eigen::Isometry) * scene_.poses[b]);
    }

    const Scene& scene_;
    std::vector<std::unique_ptr<NarrowPeer>> peers_; ///< by pair of geometries
    std::vector<PoseBounds> bounds_;                 ///< by geometry
    std::vector<Aabb> boxes_;
    std::vector<std::uint32_t> moving_;
    std::unique_ptr<BroadPeer> broad_; ///< null: the two bodies are always the pair
    std::vector<BodyPair> candidates_;
    std::size_t bytes_ = 0;
};

/// The reason why the library cannot play the scene; empty if it can.
std::string why_not(const std::string& narrow_name, const Scene& scene)
{
    const Contenders contenders = all_contenders();
    const NarrowContender& narrow = contender(contenders.narrow, narrow_name);
    for (GeometryId used : scene.geometry) {
        const auto* mesh = std::get_if<Mesh>(&scene.geometries[index(used)].data);
        const std::string& name = scene.geometries[index(used)].name;
        if (!mesh) return fmt::format("supports only meshes, and '{}' is not a mesh", name);
        if (mesh->triangles.size() < narrow.least)
            return fmt::format("crashes on meshes of fewer than {} triangles, such as '{}'", narrow.least, name);
    }
    if (const std::size_t pairs = geometry_pairs(scene).size(); pairs > most_structures)
        return fmt::format("needs a structure per pair of geometries, and {} are more than {}", grouped(pairs),
                           most_structures);
    return {};
}

/// Makes one structure per pair of geometries whose bodies may collide. A scene's pairs come from the broad phase
/// `broad_name`, over AABBs of oncollide; two meshes in poses need none.
std::unique_ptr<StudyPlayer> make_mesh_player(const std::string& broad_name, const std::string& narrow_name,
                                              const StudyWorkload& workload)
{
    const Contenders contenders = all_contenders();
    trim_memory();
    const std::size_t before = resident_memory();
    auto player =
        std::make_unique<MeshPlayer>(workload.scene, contender(contenders.narrow, narrow_name),
                                     workload.is_poses() ? nullptr : &contender(contenders.broad, broad_name));
    trim_memory();
    player->set_bytes(std::max(before, resident_memory()) - before);
    return player;
}

PeerKind mesh_peer(const char* name, const char* library, const char* broad, const char* narrow, bool by_default)
{
    std::string package;
    for (const MissingPeer& peer : all_contenders().narrow.missing)
        if (peer.library == library) package = peer.package;
    return {.name = name,
            .library = library,
            .package = package,
            .by_default = by_default,
            .why_not = [narrow = std::string(narrow)](const Scene& scene) { return why_not(narrow, scene); },
            .make = [broad = std::string(broad), narrow = std::string(narrow)](
                        const StudyWorkload& workload) { return make_mesh_player(broad, narrow, workload); }};
}

} // namespace

std::vector<PeerKind> study_peers()
{
    return {fcl_peer(), mesh_peer("ode", "ODE", "kd", "ode", true), // ODE's own spaces are not measured
            mesh_peer("bullet", "Bullet", "bullet-dbvt", "bullet-gimpact", true),
            mesh_peer("embree", "Embree", "embree-rebuild", "embree-refit", false),
            mesh_peer("cgal", "CGAL", "cgal", "cgal", false)};
}

} // namespace oncollide::tools
