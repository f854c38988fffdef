#include "league/judge/league_case.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "render/drawn_mesh.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr std::array<std::string_view, LEAGUE_QUESTION_COUNT> question_names{
    "meet", "distance", "depth", "contacts", "cast", "turn", "ray", "pairs", "self"};
constexpr std::array<std::string_view, LEAGUE_KIND_COUNT> kind_names{
    "mesh", "hull", "sphere", "capsule", "box", "cylinder", "cone", "ellipsoid", "half-space", "terrain", "cells"};

void round(double& x)
{
    x = double(float(x));
}
void round(Vector3d& v)
{
    v = v.cast<float>().cast<double>();
}
void round(Mesh& mesh)
{
    for (Vector3d& v : mesh.vertices) round(v);
    mesh = make_mesh("mesh", std::move(mesh.vertices), std::move(mesh.triangles));
}
void round(Shape& shape)
{
    if (auto* sphere = std::get_if<Sphere>(&shape)) round(sphere->radius);
    if (auto* box = std::get_if<Box>(&shape)) round(box->half);
    if (auto* capsule = std::get_if<Capsule>(&shape)) round(capsule->radius), round(capsule->length);
    if (auto* cylinder = std::get_if<Cylinder>(&shape)) round(cylinder->radius), round(cylinder->length);
    if (auto* cone = std::get_if<Cone>(&shape)) round(cone->radius), round(cone->length);
    if (auto* ellipsoid = std::get_if<Ellipsoid>(&shape)) round(ellipsoid->semi_axes);
    if (auto* hull = std::get_if<ConvexHull>(&shape))
        for (Vector3d& p : hull->points) round(p);
}
void round(LeagueBody& body)
{
    if (auto* mesh = std::get_if<Mesh>(&body.geometry)) round(*mesh);
    if (auto* shape = std::get_if<Shape>(&body.geometry)) round(*shape);
    body.pose.matrix() = body.pose.matrix().cast<float>().cast<double>().eval(); // maps and terrains are exact in float
}

void add_vertices(std::vector<double>& column, std::span<const Vector3d> vertices)
{
    for (const Vector3d& v : vertices) column.insert(column.end(), v.data(), v.data() + 3);
}

/// The mesh of a body for people.
Mesh drawn(const LeagueBody& body)
{
    if (const auto* mesh = std::get_if<Mesh>(&body.geometry)) return *mesh;
    if (const auto* terrain = std::get_if<Terrain>(&body.geometry)) return mesh_of(*terrain);
    if (const auto* map = std::get_if<OccupancyMap>(&body.geometry)) {
        std::vector<Aabb> boxes;
        map->each_box([&](const Aabb& box) { boxes.push_back(box); });
        return mesh_of_boxes("map", boxes);
    }
    const auto& shape = std::get<Shape>(body.geometry);
    if (std::holds_alternative<HalfSpace>(shape))
        return make_mesh("half-space", {{-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0}},
                         {{0, 1, 2}, {0, 2, 3}});
    return bounding_mesh_of(shape).mesh;
}

} // namespace

std::string_view name_of(league_question question)
{
    return question_names[std::size_t(question)];
}

std::string_view name_of(league_kind kind)
{
    return kind_names[std::size_t(kind)];
}

double LeagueBody::size() const
{
    const auto* shape = std::get_if<Shape>(&geometry);
    return shape && std::holds_alternative<HalfSpace>(*shape) ? 0 : bounds_of(geometry).diagonal();
}

Eigen::Isometry3d LeagueCase::pose_of_b(double time) const
{
    Eigen::Isometry3d pose = b.pose;
    pose.translation() += time * motion;
    if (!turn.isZero()) pose.linear() = Eigen::AngleAxisd(time * turn.norm(), turn.normalized()) * b.pose.linear();
    return pose;
}

LeagueCase rounded_to_float(LeagueCase asked)
{
    if (asked.question != LEAGUE_PAIRS) round(asked.a);
    if (asked.has_b()) round(asked.b);
    round(asked.from), round(asked.motion), round(asked.turn);
    for (LeagueBody& body : asked.bodies) round(body);
    return asked;
}

AskedCase::AskedCase(LeagueCase asked) : case_(std::move(asked))
{
    columns_.reserve(case_.bodies.size() + 2); // their addresses stay
    view_.question = case_.question;
    if (case_.question != LEAGUE_PAIRS) view_.a = form_of(case_.a);
    if (case_.has_b()) view_.b = form_of(case_.b);
    for (const LeagueBody& body : case_.bodies) bodies_.push_back(form_of(body));
    std::copy_n(case_.from.data(), 3, view_.from), std::copy_n(case_.motion.data(), 3, view_.motion);
    std::copy_n(case_.turn.data(), 3, view_.turn);
    view_.body_count = bodies_.size(), view_.bodies = bodies_.data();
}

league_body AskedCase::form_of(const LeagueBody& body)
{
    Columns& columns = columns_.emplace_back();
    league_body form{};
    form.solid = body.solid;
    const auto take = [&](const Mesh& mesh) {
        add_vertices(columns.vertices, mesh.vertices);
        for (const Triangle& t : mesh.triangles) columns.triangles.insert(columns.triangles.end(), t.begin(), t.end());
    };
    const auto is = [&](league_kind kind, double x = 0, double y = 0, double z = 0) {
        form.kind = kind, form.size[0] = x, form.size[1] = y, form.size[2] = z;
    };
    if (const auto* mesh = std::get_if<Mesh>(&body.geometry)) is(LEAGUE_MESH), take(*mesh);
    if (const auto* terrain = std::get_if<Terrain>(&body.geometry)) is(LEAGUE_TERRAIN), take(mesh_of(*terrain));
    if (const auto* map = std::get_if<OccupancyMap>(&body.geometry)) {
        is(LEAGUE_CELLS, map->resolution());
        map->each_cell(map->bounds(), [&](const MapCell& cell) {
            for (std::int32_t k = 0; k < cell.side * cell.side * cell.side; ++k) {
                const Vector3d at(cell.x + k % cell.side + 0.5, cell.y + k / cell.side % cell.side + 0.5,
                                  cell.z + k / cell.side / cell.side + 0.5);
                add_vertices(columns.vertices, std::array{Vector3d(map->resolution() * at)});
            }
            return true;
        });
    }
    if (const auto* shape = std::get_if<Shape>(&body.geometry)) {
        if (const auto* s = std::get_if<Sphere>(shape)) is(LEAGUE_SPHERE, s->radius);
        if (const auto* s = std::get_if<Box>(shape)) is(LEAGUE_BOX, s->half.x(), s->half.y(), s->half.z());
        if (const auto* s = std::get_if<Capsule>(shape)) is(LEAGUE_CAPSULE, s->radius, s->length / 2);
        if (const auto* s = std::get_if<Cylinder>(shape)) is(LEAGUE_CYLINDER, s->radius, s->length / 2);
        if (const auto* s = std::get_if<Cone>(shape)) is(LEAGUE_CONE, s->radius, s->length / 2);
        if (const auto* s = std::get_if<Ellipsoid>(shape))
            is(LEAGUE_ELLIPSOID, s->semi_axes.x(), s->semi_axes.y(), s->semi_axes.z());
        if (const auto* s = std::get_if<ConvexHull>(shape)) is(LEAGUE_HULL), add_vertices(columns.vertices, s->points);
        if (std::holds_alternative<HalfSpace>(*shape)) is(LEAGUE_HALF_SPACE);
    }
    form.vertex_count = columns.vertices.size() / 3, form.vertices = columns.vertices.data();
    form.triangle_count = columns.triangles.size() / 3, form.triangles = columns.triangles.data();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) form.rotation[3 * row + column] = body.pose.linear()(row, column);
    std::copy_n(body.pose.translation().data(), 3, form.position);
    return form;
}

nlohmann::json json_of(const league_case& asked)
{
    using nlohmann::json;
    const auto body = [](const league_body& b) {
        json vertices = json::array(), triangles = json::array();
        for (std::size_t k = 0; k < b.vertex_count; ++k)
            vertices.push_back({b.vertices[3 * k], b.vertices[3 * k + 1], b.vertices[3 * k + 2]});
        for (std::size_t k = 0; k < b.triangle_count; ++k)
            triangles.push_back({b.triangles[3 * k], b.triangles[3 * k + 1], b.triangles[3 * k + 2]});
        return json{{"kind", name_of(league_kind(b.kind))},
                    {"solid", b.solid},
                    {"size", b.size},
                    {"vertices", std::move(vertices)},
                    {"triangles", std::move(triangles)},
                    {"rotation", b.rotation},
                    {"position", b.position}};
    };
    json out{{"question", name_of(league_question(asked.question))}};
    if (asked.question == LEAGUE_PAIRS) {
        out["bodies"] = json::array();
        for (std::size_t k = 0; k < asked.body_count; ++k) out["bodies"].push_back(body(asked.bodies[k]));
        return out;
    }
    out["a"] = body(asked.a);
    if (asked.question < LEAGUE_RAY) out["b"] = body(asked.b);
    if (asked.question >= LEAGUE_CAST) out["from"] = asked.from, out["motion"] = asked.motion;
    if (asked.question == LEAGUE_TURN) out["turn"] = asked.turn;
    return out;
}

std::string obj_of(const LeagueCase& asked)
{
    std::string text;
    std::size_t first = 1;
    const auto add = [&](const std::string& name, const LeagueBody& body) {
        const Mesh mesh = drawn(body);
        text += fmt::format("o {}\n", name);
        for (const Vector3d& v : mesh.vertices) {
            const Vector3d p = body.pose * v;
            text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", p.x(), p.y(), p.z());
        }
        for (const Triangle& t : mesh.triangles)
            text += fmt::format("f {} {} {}\n", t[0] + first, t[1] + first, t[2] + first);
        first += mesh.vertices.size();
    };
    if (asked.question != LEAGUE_PAIRS) add("a", asked.a);
    if (asked.has_b()) add("b", asked.b);
    for (std::size_t k = 0; k < asked.bodies.size(); ++k) add(fmt::format("body-{}", k), asked.bodies[k]);
    if (asked.question == LEAGUE_RAY) {
        const Vector3d to = asked.from + asked.motion;
        text += fmt::format("o ray\nv {:.17g} {:.17g} {:.17g}\nv {:.17g} {:.17g} {:.17g}\nl {} {}\n", asked.from.x(),
                            asked.from.y(), asked.from.z(), to.x(), to.y(), to.z(), first, first + 1);
    }
    return text;
}

} // namespace oncollide::tools
