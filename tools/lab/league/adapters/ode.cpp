// ODE's dCollide() and its spaces.
#include <algorithm>
#include <array>
#include <cstdarg>
#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include <ode/ode.h>

#define LEAGUE_WITH_HULL_FACES
#include "common.hpp"

namespace {

using league::Vector;
static_assert(std::is_same_v<dReal, double>, "Link with ODE in double precision.");

/// ODE must be initialised once per process, for each thread, and closed at the end.
void start_ode()
{
    static const struct Library {
        Library()
        {
            dInitODE2(0), dSetMessageHandler([](int, const char*, va_list) {});
        }
        ~Library() { dCloseODE(); }
    } library;
    if (!dAllocateODEDataForThread(dAllocateMaskAll)) throw std::bad_alloc();
}

struct DestroyGeometry {
    void operator()(dGeomID geometry) const { dGeomDestroy(geometry); }
};
using Geometry = std::unique_ptr<dxGeom, DestroyGeometry>;

struct DestroyMesh {
    void operator()(dTriMeshDataID data) const { dGeomTriMeshDataDestroy(data); }
};

void place(dGeomID geometry, const league_body& body, const Vector& origin)
{
    dMatrix3 rotation{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rotation[4 * row + column] = body.rotation[3 * row + column];
    const Vector position = league::to_world(body, origin);
    dGeomSetPosition(geometry, position[0], position[1], position[2]);
    dGeomSetRotation(geometry, rotation);
}

/// ODE's geometries keep pointers to the arrays of meshes and hulls.
class Body {
public:
    explicit Body(const league_body& body)
    {
        const double x = body.size[0], y = body.size[1], z = body.size[2];
        Vector origin{};
        switch (body.kind) {
        case LEAGUE_MESH:
        case LEAGUE_TERRAIN:
            make_mesh(body);
            break;
        case LEAGUE_HULL:
            origin = make_hull(body);
            break;
        case LEAGUE_SPHERE:
            geometry_.reset(dCreateSphere(nullptr, x));
            break;
        case LEAGUE_CAPSULE:
            geometry_.reset(dCreateCapsule(nullptr, x, 2 * y));
            break;
        case LEAGUE_BOX:
            geometry_.reset(dCreateBox(nullptr, 2 * x, 2 * y, 2 * z));
            break;
        case LEAGUE_CYLINDER:
            geometry_.reset(dCreateCylinder(nullptr, x, 2 * y));
            break;
        case LEAGUE_HALF_SPACE:
            make_plane(body);
            return; // A plane has no pose.
        default:
            throw std::domain_error("ODE has no such kind");
        }
        place(geometry_.get(), body, origin);
        // This brings the AABB up to date, as a space does; dCollide() of a hull and a mesh reads it.
        dReal box[6];
        dGeomGetAABB(geometry_.get(), box);
    }

    dGeomID get() const { return geometry_.get(); }

private:
    void make_mesh(const league_body& body)
    {
        numbers_.assign(body.vertices, body.vertices + 3 * body.vertex_count);
        indices_.assign(body.triangles, body.triangles + 3 * body.triangle_count);
        mesh_.reset(dGeomTriMeshDataCreate());
        dGeomTriMeshDataBuildDouble(mesh_.get(), numbers_.data(), 3 * sizeof(double), int(body.vertex_count),
                                    indices_.data(), int(indices_.size()), 3 * sizeof(dTriIndex));
        dGeomTriMeshDataPreprocess2(mesh_.get(), 1u << dTRIDATAPREPROCESS_BUILD_FACE_ANGLES, nullptr); // for hulls
        geometry_.reset(dCreateTriMesh(nullptr, mesh_.get(), nullptr, nullptr, nullptr));
    }

    /// The returned point is the origin of ODE's hull, which must be inside of it.
    Vector make_hull(const league_body& body)
    {
        const league::Hull hull = league::hull_of(body);
        const Vector middle = league::mean_vertex(body);
        for (const Vector& p : hull.points)
            for (std::size_t k = 0; k < 3; ++k) numbers_.push_back(p[k] - middle[k]);
        for (const league::Face& face : hull.faces) {
            const auto& [x, y, z] = face.normal;
            const double distance = face.distance - (x * middle[0] + y * middle[1] + z * middle[2]);
            planes_.insert(planes_.end(), {x, y, z, distance});
            polygons_.push_back(unsigned(face.corners.size()));
            polygons_.insert(polygons_.end(), face.corners.begin(), face.corners.end());
        }
        geometry_.reset(dCreateConvex(nullptr, planes_.data(), unsigned(planes_.size() / 4), numbers_.data(),
                                      unsigned(hull.points.size()), polygons_.data()));
        return middle;
    }

    void make_plane(const league_body& body)
    {
        const Vector up{body.rotation[2], body.rotation[5], body.rotation[8]};
        const double height = up[0] * body.position[0] + up[1] * body.position[1] + up[2] * body.position[2];
        geometry_.reset(dCreatePlane(nullptr, up[0], up[1], up[2], height));
    }

    std::vector<double> numbers_, planes_;
    std::vector<dTriIndex> indices_;
    std::vector<unsigned> polygons_;
    std::unique_ptr<dxTriMeshData, DestroyMesh> mesh_;
    Geometry geometry_; ///< declared last: destroyed before the data that it points to
};

class Meet final : public league::Query {
public:
    explicit Meet(const league_case& asked) : a_(asked.a), b_(asked.b) {}

    int answer(const league_case&, league_answer& answer) override
    {
        dContactGeom contact;
        answer.meet = dCollide(a_.get(), b_.get(), int(1u | CONTACTS_UNIMPORTANT), &contact, sizeof contact) > 0;
        return LEAGUE_ANSWERED;
    }

private:
    Body a_, b_;
};

class Contacts final : public league::Query {
public:
    explicit Contacts(const league_case& asked) : a_(asked.a), b_(asked.b) {}

    int answer(const league_case& asked, league_answer& answer) override
    {
        const int count = dCollide(a_.get(), b_.get(), int(found_.size()), found_.data(), sizeof found_[0]);
        for (int i = 0; i < count; ++i) {
            const dContactGeom& found = found_[std::size_t(i)];
            league_contact& contact = contacts_[std::size_t(i)];
            for (int k = 0; k < 3; ++k) {
                contact.position[k] = found.pos[k];
                contact.normal[k] = -found.normal[k]; // It points into a.
            }
            contact.depth = found.depth;
        }
        answer.meet = count > 0;
        if (asked.question == LEAGUE_CONTACTS) {
            answer.contacts = contacts_.data(), answer.contact_count = std::size_t(count);
        } else if (answer.meet) {
            const league_contact& deepest =
                *std::max_element(contacts_.begin(), contacts_.begin() + count,
                                  [](const auto& p, const auto& q) { return p.depth < q.depth; });
            answer.depth = deepest.depth;
            std::copy_n(deepest.normal, 3, answer.normal);
        }
        return LEAGUE_ANSWERED;
    }

private:
    Body a_, b_;
    std::array<dContactGeom, 64> found_{};
    std::array<league_contact, 64> contacts_{};
};

class Ray final : public league::Query {
public:
    explicit Ray(const league_case& asked)
        : a_(asked.a), length_(league::length_of({asked.motion[0], asked.motion[1], asked.motion[2]})),
          ray_(dCreateRay(nullptr, length_))
    {
        if (!(length_ > 0)) throw std::domain_error("a ray needs a direction");
        const double *p = asked.from, *d = asked.motion;
        dGeomRaySet(ray_.get(), p[0], p[1], p[2], d[0], d[1], d[2]);
        dGeomRaySetClosestHit(ray_.get(), 1);
        dGeomRaySetBackfaceCull(ray_.get(), 0);
    }

    int answer(const league_case&, league_answer& answer) override
    {
        dContactGeom contact;
        answer.meet = dCollide(ray_.get(), a_.get(), 1, &contact, sizeof contact) > 0;
        answer.time = answer.meet ? contact.depth / length_ : 0;
        return LEAGUE_ANSWERED;
    }

private:
    Body a_;
    double length_;
    Geometry ray_;
};

dSpaceID make_hash_space()
{
    return dHashSpaceCreate(nullptr);
}

dSpaceID make_sweep_space()
{
    return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
}

using MakeSpace = dSpaceID();

class Boxes final : public league::Query {
public:
    Boxes(const league_case& asked, MakeSpace& make) : space_(make())
    {
        for (std::size_t i = 0; i < asked.body_count; ++i) {
            const league_body& body = asked.bodies[i];
            const double* size = body.size;
            const dGeomID box = dCreateBox(space_, 2 * size[0], 2 * size[1], 2 * size[2]);
            place(box, body, {});
            dGeomSetData(box, reinterpret_cast<void*>(i));
        }
        dSpaceClean(space_);
    }
    ~Boxes() override { dSpaceDestroy(space_); } // It destroys its boxes.

    int answer(const league_case&, league_answer& answer) override
    {
        pairs_.clear();
        dSpaceCollide(space_, &pairs_, [](void* pairs, dGeomID a, dGeomID b) {
            for (const dGeomID box : {a, b})
                static_cast<std::vector<std::uint32_t>*>(pairs)->push_back(
                    std::uint32_t(reinterpret_cast<std::uintptr_t>(dGeomGetData(box))));
        });
        answer.pair_count = pairs_.size() / 2;
        answer.pairs = pairs_.data();
        return LEAGUE_ANSWERED;
    }

private:
    dSpaceID space_;
    std::vector<std::uint32_t> pairs_;
};

bool has_kind(int kind)
{
    return league::has_triangles(kind) || kind == LEAGUE_HALF_SPACE ||
           (league::is_convex(kind) && kind != LEAGUE_CONE && kind != LEAGUE_ELLIPSOID);
}

int supports(int question, int a, int b)
{
    const auto is_round_or_flat = [](int kind) { return has_kind(kind) && !league::has_triangles(kind); };
    const bool planes = a == LEAGUE_HALF_SPACE && b == LEAGUE_HALF_SPACE;
    switch (question) {
    case LEAGUE_MEET:
    case LEAGUE_CONTACTS:
        return has_kind(a) && has_kind(b) && !planes;
    case LEAGUE_DEPTH: // A contact of a mesh is the contact of one triangle.
        return is_round_or_flat(a) && is_round_or_flat(b) && !planes;
    case LEAGUE_RAY:
        return has_kind(a);
    default:
        return question == LEAGUE_PAIRS;
    }
}

template <MakeSpace& make_space>
std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    if (league::needs_inside(asked)) return nullptr;
    start_ode();
    switch (asked.question) {
    case LEAGUE_MEET:
        return std::make_unique<Meet>(asked);
    case LEAGUE_DEPTH:
    case LEAGUE_CONTACTS:
        return std::make_unique<Contacts>(asked);
    case LEAGUE_RAY:
        return std::make_unique<Ray>(asked);
    default:
        return std::make_unique<Boxes>(asked, make_space);
    }
}

constexpr league_library libraries[] = {
    league::library_of<prepare<make_hash_space>>({
        .name = "ode",
        .settings = "0.16.2, double precision; dCollide(), at most 64 contacts (depth: the deepest), dGeomRay with its "
                    "closest hit, "
                    "dHashSpace; dGeomTriMesh (inside: floats), dConvex",
        .source = "ode/collision.h, ode/contact.h, ode/collision_space.h",
        .supports = supports,
        .precision = 1e-5,
    }),
    league::library_of<prepare<make_sweep_space>>({
        .name = "ode-sap",
        .settings = "0.16.2, double precision; dSweepAndPruneSpace, axes in the order x, y, z",
        .source = "ode/collision_space.h",
        .supports = [](int question, int, int) { return int(question == LEAGUE_PAIRS); },
        .precision = 1e-5,
    }),
};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
