// oncollide-lab bench rays: which of many segments meet a mesh, a terrain or a map, and where, compared with other
// libraries.
#include "bench/common/benchmark.hpp"
#include "peers/peers.hpp"

#include <algorithm>
#include <filesystem>

#include <octomap/octomap.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/shapes/cell_test.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct RaysOptions : SharedOptions {
    std::string mesh; ///< file; empty: generated hills and a building
    int triangles = 500'000;
    int rays = 10'000; ///< of each kind
};

constexpr const char* ray_kinds[] = {"slanted", "vertical", "short"};

/// slanted: down through the box's height, in any direction, 0.37 to 0.42 of the box's diagonal long; vertical: from
/// top to bottom; short: a hundredth of the diagonal, anywhere.
std::vector<Segment> make_rays(const std::string& kind, const Aabb& box, std::size_t count, std::uint64_t seed)
{
    const Eigen::Vector3d size = box.max - box.min;
    std::vector<Segment> rays;
    for (std::uint64_t i = 0; i < count; ++i) {
        const auto draw = [&](std::uint64_t k) { return u01(seed, i, k); };
        const Eigen::Vector3d at = box.min + size.cwiseProduct(Eigen::Vector3d(draw(0), draw(1), draw(2)));
        const double turn = 2 * M_PI * draw(3);
        if (kind == "vertical") {
            rays.push_back({{at.x(), at.y(), box.max.z() + 1}, {at.x(), at.y(), box.min.z() - 1}});
        } else if (kind == "short") {
            const Eigen::Vector3d way = Eigen::Vector3d(std::cos(turn), std::sin(turn), 2 * draw(4) - 1).normalized();
            rays.push_back({at, at + 0.01 * size.norm() * way});
        } else {
            const double length = (0.37 + 0.05 * draw(4)) * size.norm();
            const double drop = std::min(size.z(), 0.9 * length), across = std::sqrt(length * length - drop * drop);
            const Eigen::Vector3d from(at.x(), at.y(), box.max.z());
            rays.push_back({from, from + Eigen::Vector3d(across * std::cos(turn), across * std::sin(turn), -drop)});
        }
    }
    return rays;
}

/// A World of one body.
class WorldRays final : public RayPeer {
public:
    /// @param first  finds the first points of the segments, too
    WorldRays(std::shared_ptr<const Geometry> geometry, bool together, bool first) : together_(together), first_(first)
    {
        world_.bodies().add({.model = world_.models().add(std::move(geometry)), .is_static = true});
        world_.step();
    }
    void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) override
    {
        if (first_) return cast(segments, hit);
        if (!together_) {
            for (std::size_t i = 0; i < segments.size(); ++i) hit[i] = !world_.space().overlaps(segments[i]).empty();
            return;
        }
        world_.space().overlaps(segments, {}, found_);
        for (std::size_t i = 0; i < segments.size(); ++i) hit[i] = found_.offsets[i + 1] > found_.offsets[i];
    }

private:
    void cast(std::span<const Segment> segments, std::span<std::uint8_t> hit)
    {
        if (!together_) {
            for (std::size_t i = 0; i < segments.size(); ++i) hit[i] = bool(world_.space().cast(segments[i]).body);
            return;
        }
        casts_.resize(segments.size());
        world_.space().cast(segments, {}, casts_);
        for (std::size_t i = 0; i < segments.size(); ++i) hit[i] = bool(casts_[i].body);
    }

    World world_;
    bool together_, first_;
    Lists<QueryHit> found_;
    std::vector<CastHit> casts_;
};

class OctomapRays final : public RayPeer {
public:
    OctomapRays(const OccupancyMap& map, std::span<const Aabb> cells) : tree_(map.resolution())
    {
        const double side = map.resolution();
        for (const Aabb& cell : cells)
            for (double x = cell.min.x() + side / 2; x < cell.max.x(); x += side)
                for (double y = cell.min.y() + side / 2; y < cell.max.y(); y += side)
                    for (double z = cell.min.z() + side / 2; z < cell.max.z(); z += side)
                        tree_.updateNode(x, y, z, true, true);
        tree_.updateInnerOccupancy();
        tree_.prune();
    }
    void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) override
    {
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const auto point = [](const Eigen::Vector3d& p) {
                return octomap::point3d(float(p.x()), float(p.y()), float(p.z()));
            };
            octomap::point3d end;
            hit[i] = tree_.castRay(point(segments[i].from), point(segments[i].to) - point(segments[i].from), end, true,
                                   (segments[i].to - segments[i].from).norm());
        }
    }

private:
    octomap::OcTree tree_;
};

/// A geometry, its contenders, and its parts for the truth.
struct RayCase {
    std::string name;
    Aabb box;
    std::vector<RayContender> contenders;
    Mesh mesh;               ///< of a mesh or a terrain
    std::vector<Aabb> cells; ///< of a map

    std::size_t parts() const { return mesh.triangles.size() + cells.size(); }
    /// From every triangle and cell, exactly.
    bool meets(const Segment& s) const
    {
        const TrianglePoints flat{s.from, s.to, s.to};
        Aabb around;
        around.add(s.from), around.add(s.to);
        const auto met = [&](const Triangle& t) {
            const TrianglePoints points{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
            Aabb bounds;
            for (const Eigen::Vector3d& p : points) bounds.add(p);
            return bounds.overlaps(around) && triangles_meet(flat, points);
        };
        return std::ranges::any_of(mesh.triangles, met) ||
               std::ranges::any_of(cells, [&](const Aabb& cell) { return cell_meets(cell, flat); });
    }
};

void add_oncollide(RayCase& in, GeometryData data)
{
    const auto geometry = std::make_shared<const Geometry>(Geometry{{}, std::move(data), {}});
    for (const bool first : {false, true})
        for (const bool together : {false, true})
            in.contenders.push_back(
                {.name = fmt::format("oncollide{}{}", first ? "-cast" : "", together ? "-batch" : ""),
                 .what = fmt::format("World::{}, {}", first ? "cast" : "query",
                                     together ? "all segments in one call" : "one call each"),
                 .make = [=](const Mesh&) { return std::make_unique<WorldRays>(geometry, together, first); }});
}

RayCase mesh_case(const std::string& name, const Mesh& mesh, const RayContenders& peers)
{
    RayCase in{name, mesh.bounds, {}, mesh, {}};
    add_oncollide(in, mesh);
    for (const RayContender& peer : peers.all)
        if (mesh.triangles.size() <= peer.most)
            in.contenders.push_back(peer);
        else
            say("left out   {}: supports at most {} triangles\n", peer.name, grouped(peer.most));
    return in;
}

RayCase terrain_case(const std::string& name, const Terrain& terrain)
{
    RayCase in{name, terrain.bounds(), {}, mesh_of(terrain), {}};
    add_oncollide(in, terrain);
    return in;
}

RayCase map_case(const std::string& name, const OccupancyMap& map)
{
    RayCase in{name, map.bounds(), {}, {}, {}};
    map.each_cell(map.bounds(), [&](const MapCell& cell) {
        in.cells.push_back(map.box(cell));
        return true;
    });
    add_oncollide(in, map);
    in.contenders.push_back(
        {.name = "octomap",
         .what = "OctoMap castRay, which follows the cells along the ray",
         .promise = Promise::approximate,
         .make = [map, cells = in.cells](const Mesh&) { return std::make_unique<OctomapRays>(map, cells); }});
    return in;
}

std::vector<RayCase> cases_of(const RaysOptions& options, const RayContenders& peers)
{
    if (!options.mesh.empty())
        return {mesh_case(std::filesystem::path(options.mesh).stem().string(), load_mesh(options.mesh), peers)};
    const auto side = std::uint32_t(std::lround(std::sqrt(options.triangles / 2.0)));
    const double height = 0.08 * side;
    return {mesh_case("hills, mesh", make_hills_mesh(side, 1, height, options.seed, 0, 0, side), peers),
            terrain_case("hills, terrain", make_hills(side, side, 1, height, options.seed)),
            map_case("building, map", make_building_map(20, 0.1, options.seed))};
}

using Hits = std::vector<std::uint8_t>; ///< by segment

/// The hits and the least time of a contender, by kind of segment.
struct RayResult {
    double build_ms = 0, first_ms = 0; ///< of its data; until the result of the first segment
    std::vector<double> us;            ///< per segment
    std::vector<Hits> hits;
};

RayResult measure(const RayContender& contender, const Mesh& mesh, std::span<const std::vector<Segment>> rays,
                  int repeats)
{
    RayResult result;
    const auto begin = Clock::now();
    const std::unique_ptr<RayPeer> peer = contender.make(mesh);
    result.build_ms = milliseconds_since(begin);
    std::uint8_t hit;
    peer->trace(std::span(rays.front()).first(1), std::span(&hit, 1));
    result.first_ms = milliseconds_since(begin);
    for (const std::vector<Segment>& segments : rays) {
        Hits& hits = result.hits.emplace_back(segments.size());
        peer->trace(segments, hits); // warms up
        const double ms = least_ms(repeats, [&] { peer->trace(segments, hits); });
        result.us.push_back(1000 * ms / double(segments.size()));
    }
    return result;
}

/// The truth for one kind of segment: of the segments on which contenders differ, and of a hundred others, from every
/// part.
Hits judged_hits(const RayCase& in, std::span<const Segment> segments, std::span<const RayResult> results,
                 std::size_t kind)
{
    Hits truth = results.front().hits[kind];
    for (std::size_t i = 0; i < segments.size(); ++i)
        if (i < 100 || std::ranges::any_of(results, [&](const RayResult& r) { return r.hits[kind][i] != truth[i]; }))
            truth[i] = in.meets(segments[i]);
    return truth;
}

/// Segments against a mesh, a terrain and a map, compared with Embree, Bullet and OctoMap. Returns the exit code: 70 if
/// a result of oncollide is wrong.
int bench_rays(const RaysOptions& options)
{
    const RayContenders peers = all_contenders().rays;
    const std::vector<RayCase> cases = cases_of(options, peers);
    say("{}", describe_program("cpu"));
    print_missing(peers.missing);
    say("one thread; missed and invented: hits, by tests of all triangles and cells\n");
    ResultTable table(options.csv, {22, 10});
    bool wrong = false;
    for (const RayCase& in : cases) {
        table.section(fmt::format("{}, {}", in.name, grouped(in.parts())));
        table.about(figures("geometry", in.name, "parts", in.parts()));
        std::vector<std::vector<Segment>> rays;
        for (const char* kind : ray_kinds)
            rays.push_back(make_rays(kind, in.box, std::size_t(options.rays), options.seed));
        std::vector<RayResult> results;
        for (const RayContender& contender : in.contenders)
            results.push_back(measure(contender, in.mesh, rays, options.repeats));
        for (std::size_t kind = 0; kind < rays.size(); ++kind) {
            const Hits truth = judged_hits(in, rays[kind], results, kind);
            for (std::size_t c = 0; c < results.size(); ++c) {
                std::size_t hits = 0, missed = 0, invented = 0;
                for (std::size_t i = 0; i < truth.size(); ++i) {
                    const bool mine = results[c].hits[kind][i], there = truth[i];
                    hits += mine, missed += there && !mine, invented += !there && mine;
                }
                wrong |= in.contenders[c].promise == Promise::exact && (missed || invented);
                table.row(figures("contender", in.contenders[c].name, "rays", ray_kinds[kind], "us_per_ray",
                                  results[c].us[kind], "count", truth.size(), "hits", hits, "missed", missed,
                                  "invented", invented, "build_ms", results[c].build_ms, "first_ms",
                                  results[c].first_ms));
            }
        }
    }
    table.commit();
    return code_of(wrong);
}

} // namespace

void add_rays(Arguments bench)
{
    Benchmark<RaysOptions> b(bench, "rays", "Segments against a mesh, a terrain and a map", bench_rays);
    b.input("mesh FILE", b->mesh, "mesh file (default: generated hills, and a building)");
    b.whole("--triangles N", b->triangles, "approximate triangles of the hills", {100, 100'000'000});
    b.whole("--rays N", b->rays, "number of segments of each kind", {1, 10'000'000});
    b.repeats(), b.seed("the hills and the segments"), b.csv("contender and kind of segment");
    b.footer("slanted: down through the height of the box, in any direction, 0.37 to 0.42 of its diagonal long;\n"
             "vertical: from top to bottom; short: a hundredth of the diagonal, anywhere. 'first': until the result\n"
             "of the first segment, building included.\n"
             "Exit code 70: oncollide missed or invented a hit.");
}

} // namespace oncollide::tools
