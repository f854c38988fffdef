// oncollide itself: exact, within an error, and by sphere-trees of the CPU and of OpenGL.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include <oncollide/pipeline/world/world_access.hpp>

#include "common.hpp"
#include "shared_backend.hpp"

namespace {

using namespace oncollide;
using Eigen::Vector3d;

enum class Way { exact, within, spheres, gpu };

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

/// The motion of b. A piece of it turns by less than a half turn.
RigidMotion motion_of(const league_case& asked)
{
    const Eigen::Isometry3d from = pose_of(asked.b);
    const Vector3d turn(asked.turn);
    const int pieces = 1 + int(turn.norm() / 2);
    std::vector<RigidMotion::Key> keys;
    for (int k = 0; k <= pieces; ++k) {
        const double time = double(k) / pieces;
        Eigen::Isometry3d pose = from;
        pose.translation() += time * Vector3d(asked.motion);
        if (!turn.isZero()) pose.linear() = Eigen::AngleAxisd(time * turn.norm(), turn.normalized()) * from.linear();
        keys.push_back({time, pose});
    }
    return RigidMotion(keys);
}

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
    settings.bounding_volume = way == Way::within ? BoundingVolume::obb : BoundingVolume::sphere;
    settings.backend = BackendKind::cpu;
    return settings;
}

/// An exception other than Error ends the process: it is a fault of oncollide.
class Case final : public league::Query {
public:
    Case(Way way, const league_case& asked)
        : world_(WorldAccess::make(settings_of(way, asked),
                                   way == Way::gpu ? std::make_unique<league::SharedBackend>() : nullptr))
    {
        if (asked.question != LEAGUE_PAIRS) add(asked.a);
        if (asked.question < LEAGUE_RAY) add(asked.b);
        for (std::size_t k = 0; k < asked.body_count; ++k) add(asked.bodies[k]);
    }

    int answer(const league_case& asked, league_answer& answer) noexcept override
    try {
        switch (asked.question) {
        case LEAGUE_MEET:
            answer.meet = world_.pairs().decide(bodies_[0], bodies_[1]).verdict != Verdict::separate;
            return LEAGUE_ANSWERED;
        case LEAGUE_DISTANCE: {
            const Distance found = world_.pairs().distance(bodies_[0], bodies_[1]);
            answer.distance = found.upper, answer.error = found.upper - found.lower, answer.has_points = true;
            set(answer.point_a, found.point_a), set(answer.point_b, found.point_b);
            return LEAGUE_ANSWERED;
        }
        case LEAGUE_DEPTH: {
            const Penetration found = world_.pairs().penetration(bodies_[0], bodies_[1]);
            answer.meet = found.parting_upper > 0, answer.depth = found.parting_upper;
            answer.error = found.parting_upper - found.parting_lower;
            set(answer.normal, found.parting_along);
            return std::isfinite(found.parting_upper) ? LEAGUE_ANSWERED : LEAGUE_UNSUPPORTED;
        }
        case LEAGUE_CONTACTS:
            find_contacts(answer);
            return LEAGUE_ANSWERED;
        case LEAGUE_CAST:
        case LEAGUE_TURN: {
            const double far = 0x1p-48 * Vector3d(asked.b.position).cwiseAbs().maxCoeff();
            const SweepResult found =
                world_.pairs().sweep({models_[0], pose_of(asked.a)}, {models_[1], motion_of(asked)},
                                     {.time_tolerance = 1e-9, .gap_tolerance = 1e-9 + far}); // rounding hides such gaps
            answer.meet = found.verdict != Verdict::separate; // undecided: they may meet from clear_until on
            answer.time = std::isfinite(found.contact_by) ? found.contact_by : found.clear_until;
            answer.error = answer.time - found.clear_until;
            return LEAGUE_ANSWERED;
        }
        case LEAGUE_RAY: {
            const Vector3d from(asked.from);
            const CastHit hit = world_.space().cast(Segment{from, from + Vector3d(asked.motion)});
            answer.meet = hit.verdict != Verdict::separate, answer.time = hit.fraction_upper;
            return LEAGUE_ANSWERED;
        }
        case LEAGUE_SELF:
            answer.meet = !world_.models().self_contacts(models_[0], 1).empty();
            return LEAGUE_ANSWERED;
        case LEAGUE_PAIRS: {
            pairs_.clear();
            for (const PairResult& pair : world_.step().pairs)
                if (pair.verdict != Verdict::separate)
                    for (const BodyId body : {pair.a, pair.b}) pairs_.push_back(number_.at(body));
            answer.pairs = pairs_.data(), answer.pair_count = pairs_.size() / 2;
            return LEAGUE_ANSWERED;
        }
        default:
            return LEAGUE_UNSUPPORTED;
        }
    } catch (const Error&) {
        return LEAGUE_FAILED;
    }

private:
    void find_contacts(league_answer& answer)
    {
        contacts_.clear();
        double deepest = -std::numeric_limits<double>::infinity();
        for (const ManifoldPoint& p : world_.pairs().manifold(bodies_[0], bodies_[1]).points) {
            league_contact& contact = contacts_.emplace_back();
            set(contact.position, (p.point_a + p.point_b) / 2), set(contact.normal, p.normal), contact.depth = p.depth;
            if (p.depth > deepest) deepest = p.depth, answer.error = p.depth_error;
        }
        answer.meet = !contacts_.empty();
        answer.contacts = contacts_.data(), answer.contact_count = contacts_.size();
    }

    void add(const league_body& body)
    {
        models_.push_back(world_.models().add(std::make_shared<const Geometry>(Geometry{{}, geometry_of(body), {}})));
        bodies_.push_back(world_.bodies().add({.model = models_.back(), .pose = pose_of(body)}));
        number_[bodies_.back()] = std::uint32_t(number_.size());
    }

    World world_;
    std::vector<ModelId> models_;
    std::vector<BodyId> bodies_;
    std::map<BodyId, std::uint32_t> number_;
    std::vector<std::uint32_t> pairs_;
    std::vector<league_contact> contacts_;
};

template <Way way>
std::unique_ptr<league::Query> prepare(const league_case& asked) noexcept
try {
    return std::make_unique<Case>(way, asked);
} catch (const Error&) {
    return nullptr;
}

/// The GPU finds the cells of meshes alone.
template <Way way>
int supports_meet(int question, int kind_a, int kind_b)
{
    const bool has_mesh = league::has_triangles(kind_a) || league::has_triangles(kind_b);
    return question == LEAGUE_MEET && (way != Way::gpu || has_mesh);
}

template <Way way>
constexpr league_library bounded(const char* name, const char* settings)
{
    return league::library_of<prepare<way>>({.name = name,
                                             .settings = settings,
                                             .source = "docs/choosing.md",
                                             .supports = supports_meet<way>,
                                             .precision = 1e-2,
                                             .conservative = true});
}

constexpr league_library libraries[] = {
    league::library_of<prepare<Way::exact>>({
        .name = "oncollide",
        .settings = "exact results, the defaults",
        .source = "docs/results.md",
        .supports =
            [](int question, int a, int b) {
                return int(question != LEAGUE_DEPTH || !(a == LEAGUE_HALF_SPACE && b == LEAGUE_HALF_SPACE));
            },
    }),
    bounded<Way::within>("oncollide-within", "max_error of 1e-2 of the larger body; boxes"),
    bounded<Way::spheres>("oncollide-spheres", "max_error of 1e-2 of the larger body; sphere-trees"),
    bounded<Way::gpu>("oncollide-gl", "max_error of 1e-2 of the larger body; sphere-trees by gl-compute"),
};

/// An OpenGL context can be made.
bool has_gpu()
{
    static const bool found = [] {
        try {
            return describe_gpu(-1), true;
        } catch (const Error&) {
            return false;
        }
    }();
    return found;
}

} // namespace

const league_library* league_open(int number)
{
    const league_library* const library = league::library_at(libraries, number);
    return number == int(std::size(libraries)) - 1 && !has_gpu() ? nullptr : library;
}
