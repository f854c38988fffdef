// oncollide itself: exact, within an error, and by sphere-trees.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include <oncollide/pipeline/world.hpp>

#include <oncollide/league.h>

namespace {

using namespace oncollide;
using Eigen::Vector3d;

enum class Way { exact, within, spheres };

std::vector<Vector3d> points_of(const league_body& body)
{
    std::vector<Vector3d> points;
    for (std::size_t k = 0; k < body.vertex_count; ++k) points.emplace_back(body.vertices + 3 * k);
    return points;
}

GeometryData geometry_of(const league_body& body)
{
    const double* s = body.size;
    switch (body.kind) {
    case LEAGUE_SPHERE:
        return Shape(Sphere{s[0]});
    case LEAGUE_CAPSULE:
        return Shape(Capsule{s[0], 2 * s[1]});
    case LEAGUE_BOX:
        return Shape(Box{Vector3d(s)});
    case LEAGUE_CYLINDER:
        return Shape(Cylinder{s[0], 2 * s[1]});
    case LEAGUE_CONE:
        return Shape(Cone{s[0], 2 * s[1]});
    case LEAGUE_ELLIPSOID:
        return Shape(Ellipsoid{Vector3d(s)});
    case LEAGUE_HALF_SPACE:
        return Shape(HalfSpace{});
    case LEAGUE_HULL:
        return Shape(ConvexHull{points_of(body)});
    case LEAGUE_CELLS: {
        std::vector<MapCell> cells;
        for (const Vector3d& p : points_of(body)) {
            const Vector3d at = p / s[0];
            cells.push_back({int(std::floor(at.x())), int(std::floor(at.y())), int(std::floor(at.z())), 1});
        }
        return make_occupancy_map("map", s[0], cells);
    }
    default: {
        std::vector<Triangle> triangles;
        for (std::size_t k = 0; k < body.triangle_count; ++k)
            triangles.push_back({body.triangles[3 * k], body.triangles[3 * k + 1], body.triangles[3 * k + 2]});
        return make_mesh("mesh", points_of(body), std::move(triangles));
    }
    }
}

Eigen::Isometry3d pose_of(const league_body& body)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.rotation);
    pose.translation() = Vector3d(body.position);
    return pose;
}

struct Prepared {
    std::optional<World> world;
    std::vector<ModelId> models;
    std::vector<BodyId> bodies;
    std::map<BodyId, std::uint32_t> number;
    std::vector<std::uint32_t> pairs;
};

void set(double (&out)[3], const Vector3d& v)
{
    std::copy_n(v.data(), 3, out);
}

Settings settings_of(Way way, const league_case& asked)
{
    Settings settings;
    settings.mode = asked.a.solid || asked.b.solid ? Mode::solid : Mode::surface;
    settings.open_as_surface = settings.mode == Mode::solid;
    settings.threads = 1;
    if (way == Way::exact) return settings;
    double size = 0;
    for (const league_body* body : {&asked.a, &asked.b})
        if (body->kind != LEAGUE_HALF_SPACE) size = std::max(size, bounds_of(geometry_of(*body)).diagonal());
    settings.max_error = 1e-2 * size;
    settings.bounding_volume = way == Way::spheres ? BoundingVolume::sphere : BoundingVolume::obb;
    return settings;
}

void* prepare(Way way, const league_case* asked)
try {
    auto prepared = std::make_unique<Prepared>();
    World& world = prepared->world.emplace(settings_of(way, *asked));
    const auto add = [&](const league_body& body) {
        const ModelId model = world.models().add(std::make_shared<const Geometry>(Geometry{{}, geometry_of(body), {}}));
        prepared->models.push_back(model);
        prepared->bodies.push_back(world.bodies().add({.model = model, .pose = pose_of(body)}));
        prepared->number[prepared->bodies.back()] = std::uint32_t(prepared->number.size());
    };
    if (asked->question != LEAGUE_PAIRS) add(asked->a);
    if (asked->question < LEAGUE_RAY) add(asked->b);
    for (std::size_t k = 0; k < asked->body_count; ++k) add(asked->bodies[k]);
    return prepared.release();
} catch (const Error&) {
    return nullptr;
}

int answer(void* prepared_data, const league_case* asked, league_answer* out)
try {
    auto& prepared = *static_cast<Prepared*>(prepared_data);
    World& world = *prepared.world;
    const auto& bodies = prepared.bodies;
    switch (asked->question) {
    case LEAGUE_MEET:
        out->meet = world.pairs().decide(bodies[0], bodies[1]).verdict != Verdict::separate;
        return LEAGUE_ANSWERED;
    case LEAGUE_DISTANCE: {
        const Distance found = world.pairs().distance(bodies[0], bodies[1]);
        out->distance = found.upper, out->error = found.upper - found.lower, out->has_points = true;
        set(out->point_a, found.point_a), set(out->point_b, found.point_b);
        return LEAGUE_ANSWERED;
    }
    case LEAGUE_DEPTH: {
        const Penetration found = world.pairs().penetration(bodies[0], bodies[1]);
        out->meet = found.parting_upper > 0, out->depth = found.parting_upper;
        out->error = found.parting_upper - found.parting_lower;
        set(out->normal, found.parting_along);
        return std::isfinite(found.parting_upper) ? LEAGUE_ANSWERED : LEAGUE_UNSUPPORTED;
    }
    case LEAGUE_CAST: {
        const Eigen::Isometry3d from = pose_of(asked->b);
        const double rounding = 0x1p-48 * from.translation().cwiseAbs().maxCoeff(); // no gap below it is known
        Eigen::Isometry3d to = from;
        to.translation() += Vector3d(asked->motion);
        const SweepResult found =
            world.pairs().sweep({prepared.models[0], pose_of(asked->a)}, {prepared.models[1], RigidMotion(from, to)},
                                {.time_tolerance = 1e-9, .gap_tolerance = 1e-9 + rounding});
        out->meet = found.verdict != Verdict::separate;
        out->time = std::isfinite(found.contact_by) ? found.contact_by : found.clear_until;
        out->error = out->time - found.clear_until;
        return found.verdict == Verdict::undecided ? LEAGUE_FAILED : LEAGUE_ANSWERED;
    }
    case LEAGUE_RAY: {
        const Vector3d from(asked->from);
        const CastHit hit = world.space().cast(Segment{from, from + Vector3d(asked->motion)});
        out->meet = hit.verdict != Verdict::separate, out->time = hit.fraction_upper;
        return LEAGUE_ANSWERED;
    }
    case LEAGUE_SELF:
        out->meet = !world.models().self_contacts(prepared.models[0], 1).empty();
        return LEAGUE_ANSWERED;
    case LEAGUE_PAIRS: {
        prepared.pairs.clear();
        for (const PairResult& pair : world.step().pairs)
            if (pair.verdict != Verdict::separate)
                for (const BodyId body : {pair.a, pair.b}) prepared.pairs.push_back(prepared.number.at(body));
        out->pairs = prepared.pairs.data(), out->pair_count = prepared.pairs.size() / 2;
        return LEAGUE_ANSWERED;
    }
    default:
        return LEAGUE_UNSUPPORTED;
    }
} catch (const Error&) {
    return LEAGUE_FAILED;
}

void release(void* prepared)
{
    delete static_cast<Prepared*>(prepared);
}

template <Way way>
void* prepare_as(const league_case* asked)
{
    return prepare(way, asked);
}

const league_library libraries[] = {
    {LEAGUE_VERSION, 64, "oncollide", "exact results, the defaults", "docs/results.md", 0, 0,
     [](int question, int a, int b) {
         return int(question != LEAGUE_DEPTH || !(a == LEAGUE_HALF_SPACE && b == LEAGUE_HALF_SPACE));
     },
     prepare_as<Way::exact>, answer, release},
    {LEAGUE_VERSION, 64, "oncollide-within", "max_error of 1e-2 of the larger body; boxes", "docs/choosing.md", 1e-2, 1,
     [](int question, int, int) { return int(question == LEAGUE_MEET); }, prepare_as<Way::within>, answer, release},
    {LEAGUE_VERSION, 64, "oncollide-spheres", "max_error of 1e-2 of the larger body; sphere-trees", "docs/choosing.md",
     1e-2, 1, [](int question, int, int) { return int(question == LEAGUE_MEET); }, prepare_as<Way::spheres>, answer,
     release}};

} // namespace

extern "C" const league_library* league_open(int number)
{
    return number >= 0 && number < int(std::size(libraries)) ? &libraries[number] : nullptr;
}
