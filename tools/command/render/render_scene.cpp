#include "render/render_scene.hpp"
#include "render/drawn_mesh.hpp"
#include "render/shading.hpp"

#include <algorithm>

namespace oncollide::tools {

ScenePictures::ScenePictures(const Scene& scene, Shown shown)
    : scene_(scene), shown_(std::move(shown)), made_(scene.geometries.size())
{
}

const Mesh* ScenePictures::mesh_of(GeometryId id)
{
    const Geometry& geometry = scene_.geometries[index(id)];
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) return mesh;
    auto& made = made_[index(id)];
    if (!made) {
        if (const auto* map = std::get_if<OccupancyMap>(&geometry.data)) {
            std::vector<Aabb> boxes;
            map->each_box([&](const Aabb& box) { boxes.push_back(box); });
            made = std::make_unique<Mesh>(mesh_of_boxes(geometry.name, boxes));
        } else if (const auto* terrain = std::get_if<Terrain>(&geometry.data)) {
            made = std::make_unique<Mesh>(oncollide::mesh_of(*terrain));
        } else {
            made = std::make_unique<Mesh>(drawn_mesh(std::get<Shape>(geometry.data), scene_));
        }
    }
    return made.get();
}

const std::vector<ScenePictures::Sphere>& ScenePictures::spheres_of(std::uint32_t body, const TreeOf& tree_of,
                                                                    std::optional<int> level)
{
    auto& known = of_body_[body];
    if (known) return *known;
    known.emplace();
    const Ocst* tree = tree_of(scene_.geometry[body]);
    if (!tree) return *known;
    tree->for_each_cell([&](CellKey cell, bool expanded) {
        const int l = level_of(cell);
        if (level ? l != *level : expanded) return;
        known->push_back({.centre = scene_.poses[body] * tree->centre(cell),
                          .radius = tree->radius(l),
                          .fineness = float(l) / float(tree->depth()),
                          .may_touch = level || l == tree->depth()});
    });
    std::sort(known->begin(), known->end(),
              [](const Sphere& a, const Sphere& b) { return a.centre.x() < b.centre.x(); });
    return *known;
}

/// Both lists are sorted along x, so each sphere is compared only with spheres in its range.
void ScenePictures::mark_touching(std::uint32_t a, std::uint32_t b)
{
    // The spheres that decided a pair may be apart by the rounding that the pair's bound includes.
    constexpr double rounding = 1 + 1e-4;
    const auto reach = [&](double r, double s) { return (r + s) * rounding + shown_.clearance; };
    std::vector<Sphere>&one = *of_body_[a], &other = *of_body_[b];
    double largest = 0;
    for (const Sphere& s : other)
        if (s.may_touch) largest = std::max(largest, s.radius);
    for (Sphere& s : one) {
        if (!s.may_touch) continue;
        const double far = reach(s.radius, largest);
        auto from = std::lower_bound(other.begin(), other.end(), s.centre.x() - far,
                                     [](const Sphere& t, double x) { return t.centre.x() < x; });
        for (; from != other.end() && from->centre.x() <= s.centre.x() + far; ++from)
            if (from->may_touch && (from->centre - s.centre).norm() <= reach(s.radius, from->radius))
                s.red = from->red = true;
    }
}

void ScenePictures::add_spheres(Picture& picture, std::uint32_t body)
{
    for (const Sphere& sphere : *of_body_[body]) {
        Colour colour = sphere.red ? touching : colour_of(body);
        // Drawn over meshes, coarse spheres are faint: they are large, overlap each other, and carry little
        // information.
        if (shown_.meshes && !sphere.red) colour.alpha = std::uint8_t(30 + 150 * sphere.fineness * sphere.fineness);
        picture.balls.push_back({sphere.centre, sphere.radius, colour});
        red_ += sphere.red;
    }
}

void ScenePictures::find_meeting(const World& world, std::span<const PairResult> pairs)
{
    meeting_of_.assign(scene_.size(), {});
    if (!shown_.meeting) return;
    const auto is_mesh = [&](BodyId body) {
        return std::holds_alternative<Mesh>(scene_.geometries[index(scene_.geometry[index(body)])].data);
    };
    std::vector<PairOfBodies> colliding;
    for (const PairResult& pair : pairs) {
        if (pair.verdict != Verdict::colliding || !is_mesh(pair.a) || !is_mesh(pair.b)) continue;
        if (!shown_.bodies[index(pair.a)] && !shown_.bodies[index(pair.b)]) continue;
        colliding.push_back({pair.a, pair.b});
    }
    Lists<Contact> found;
    world.pairs().contacts(colliding, found);
    for (std::size_t k = 0, c = 0; k < colliding.size(); ++k)
        for (; c < found.offsets[k + 1]; ++c) {
            meeting_of_[index(colliding[k].a)].push_back(found.items[c].a.triangle);
            meeting_of_[index(colliding[k].b)].push_back(found.items[c].b.triangle);
        }
    for (std::vector<std::uint32_t>& triangles : meeting_of_) {
        std::sort(triangles.begin(), triangles.end());
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    }
}

/// Adds the mesh in two parts if some triangles intersect others: drawn over the whole mesh, red triangles would
/// flicker.
void ScenePictures::add_mesh(ScenePicture& picture, std::uint32_t body)
{
    const Mesh* whole = mesh_of(scene_.geometry[body]);
    const Eigen::Isometry3d& pose = scene_.poses[body];
    const std::vector<std::uint32_t>& meeting = meeting_of_[body];
    const auto add_part = [&](bool red) {
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t t = 0; t < whole->triangles.size(); ++t)
            if (std::binary_search(meeting.begin(), meeting.end(), t) == red) triangles.push_back(t);
        if (triangles.empty()) return;
        picture.own.push_back(std::make_shared<const Mesh>(part_of(*whole, triangles)));
        picture.bodies.push_back({picture.own.back().get(), pose, red ? touching : surface_colour(body)});
    };
    meeting_ += meeting.size();
    if (!meeting.empty()) add_part(true);
    if (!shown_.meshes) return;
    if (!meeting.empty()) return add_part(false);
    picture.own.emplace_back(scene_.geometries.share(index(scene_.geometry[body])), whole);
    picture.bodies.push_back({whole, pose, surface_colour(body)});
}

ScenePicture ScenePictures::make(const World& world, const TreeOf& tree_of, std::span<const PairResult> pairs,
                                 std::optional<int> level)
{
    ScenePicture picture;
    spheres_ = red_ = meeting_ = 0;
    find_meeting(world, pairs);
    for (std::uint32_t body = 0; body < scene_.size(); ++body)
        if (shown_.bodies[body]) add_mesh(picture, body);
    if (!shown_.spheres) return picture;

    of_body_.assign(scene_.size(), std::nullopt);
    for (const PairResult& pair : pairs) {
        const std::uint32_t a = index(pair.a), b = index(pair.b);
        if (pair.verdict == Verdict::separate || !(shown_.bodies[a] || shown_.bodies[b])) continue;
        spheres_of(a, tree_of, level), spheres_of(b, tree_of, level);
        mark_touching(a, b);
    }
    for (std::uint32_t body = 0; body < scene_.size(); ++body)
        if (shown_.bodies[body]) spheres_of(body, tree_of, level), add_spheres(picture, body);
    spheres_ = picture.balls.size();
    return picture;
}

} // namespace oncollide::tools
