// Helpers of several adapters. Define LEAGUE_WITH_HULL_FACES before it for hull_of(), which needs Qhull
// (-lqhull_r).
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <oncollide/league.h>

#ifdef LEAGUE_WITH_HULL_FACES
#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}
#endif

namespace league {

using Vector = std::array<double, 3>;

/// The body is given by triangles.
inline bool has_triangles(int kind)
{
    return kind == LEAGUE_MESH || kind == LEAGUE_TERRAIN;
}

/// The body is convex and bounded.
inline bool is_convex(int kind)
{
    return kind >= LEAGUE_HULL && kind <= LEAGUE_ELLIPSOID;
}

/// The body has an inside that a library of surfaces does not know.
inline bool is_solid_mesh(const league_body& body)
{
    return body.kind == LEAGUE_MESH && body.solid;
}

/// The point of the world at p of the body's own frame.
inline Vector to_world(const league_body& body, const Vector& p)
{
    const double *r = body.rotation, *t = body.position;
    return {r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + t[0], r[3] * p[0] + r[4] * p[1] + r[5] * p[2] + t[1],
            r[6] * p[0] + r[7] * p[1] + r[8] * p[2] + t[2]};
}

/// The direction in the body's own frame that is d in the world.
inline Vector to_body_direction(const league_body& body, const Vector& d)
{
    const double* r = body.rotation;
    return {r[0] * d[0] + r[3] * d[1] + r[6] * d[2], r[1] * d[0] + r[4] * d[1] + r[7] * d[2],
            r[2] * d[0] + r[5] * d[1] + r[8] * d[2]};
}

inline double length_of(const Vector& v)
{
    return std::hypot(v[0], v[1], v[2]);
}

/// The mean of the vertices; it is inside of their hull.
inline Vector mean_vertex(const league_body& body)
{
    Vector mean{};
    for (std::size_t i = 0; i < 3 * body.vertex_count; ++i) mean[i % 3] += body.vertices[i] / double(body.vertex_count);
    return mean;
}

/// The pose of b at a time from 0 to 1 of its motion and turn.
inline league_body b_at(const league_case& asked, double time)
{
    league_body moved = asked.b;
    for (int k = 0; k < 3; ++k) moved.position[k] += time * asked.motion[k];
    const double angle = length_of({asked.turn[0], asked.turn[1], asked.turn[2]});
    if (!(angle > 0)) return moved;
    const double x = asked.turn[0] / angle, y = asked.turn[1] / angle, z = asked.turn[2] / angle;
    const double c = std::cos(time * angle), s = std::sin(time * angle), d = 1 - c;
    const double turn[9] = {c + d * x * x,     d * x * y - s * z, d * x * z + s * y, d * x * y + s * z, c + d * y * y,
                            d * y * z - s * x, d * x * z - s * y, d * y * z + s * x, c + d * z * z};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) {
            double& to = moved.rotation[3 * row + column];
            to = 0;
            for (std::size_t k = 0; k < 3; ++k) to += turn[3 * row + k] * asked.b.rotation[3 * k + column];
        }
    return moved;
}

/// The case needs the inside of a mesh. Contacts press on its surface, and a body that comes from outside meets that
/// first.
inline bool needs_inside(const league_case& asked)
{
    const bool has_b = asked.question < LEAGUE_RAY;
    if (asked.question == LEAGUE_CONTACTS || asked.question == LEAGUE_TURN) return false;
    return asked.question != LEAGUE_PAIRS && (is_solid_mesh(asked.a) || (has_b && is_solid_mesh(asked.b)));
}

/// A case, with the trees and models that a library builds for it.
struct Query {
    Query() = default;
    Query(const Query&) = delete;
    Query& operator=(const Query&) = delete;
    virtual ~Query() = default;
    /// Fills `answer`, which is all zeros before, and returns a league_state. Throws if the library fails.
    virtual int answer(const league_case& asked, league_answer& answer) = 0;
};

/// Prepares a case. Its result is null, or it throws, if the library does not have such a case.
using Prepare = std::unique_ptr<Query>(const league_case&);

template <class Made>
std::unique_ptr<Query> make(const league_case& asked)
{
    return std::make_unique<Made>(asked);
}

/// A library in its own words; league.h explains each.
struct About {
    const char *name, *settings, *source;
    int (*supports)(int question, int kind_a, int kind_b);
    int bits = 64;
    double precision = 0;
    bool conservative = false;
};

template <Prepare& prepare>
constexpr league_library library_of(const About& about)
{
    league_library library{};
    library.version = LEAGUE_VERSION, library.bits = about.bits;
    library.name = about.name, library.settings = about.settings, library.source = about.source;
    library.precision = about.precision, library.conservative = about.conservative;
    library.supports = about.supports;
    library.prepare = [](const league_case* asked) -> void* {
        try {
            return prepare(*asked).release();
        } catch (...) {
            return nullptr;
        }
    };
    library.answer = [](void* query, const league_case* asked, league_answer* answer) -> int {
        try {
            *answer = {};
            return static_cast<Query*>(query)->answer(*asked, *answer);
        } catch (...) {
            return LEAGUE_FAILED;
        }
    };
    library.release = [](void* query) { delete static_cast<Query*>(query); };
    return library;
}

/// The result of league_open().
template <std::size_t count>
const league_library* library_at(const league_library (&libraries)[count], int number)
{
    return number >= 0 && std::size_t(number) < count ? &libraries[number] : nullptr;
}

#ifdef LEAGUE_WITH_HULL_FACES

/// A hull's face: a plane and the corners in it, counter-clockwise seen from outside.
struct Face {
    Vector normal;
    double distance; ///< of the origin: normal * p == distance
    std::vector<int> corners;
};

/// A hull of only the points that are corners of faces.
struct Hull {
    std::vector<Vector> points;
    std::vector<Face> faces;
};

/// One run of Qhull. It reports errors by a code; its output goes to /dev/null.
class Qhull {
public:
    explicit Qhull(const league_body& body) : coordinates_(body.vertices, body.vertices + 3 * body.vertex_count)
    {
        if (!quiet_) throw std::runtime_error("there is no /dev/null");
        qh_zero(&qh_, quiet_.get());
        char command[] = "qhull Pp"; // no warnings
        failed_ = qh_new_qhull(&qh_, 3, int(body.vertex_count), coordinates_.data(), False, command, nullptr,
                               quiet_.get()) != qh_ERRnone;
    }
    ~Qhull()
    {
        qh_freeqhull(&qh_, !qh_ALL);
        int long_left = 0, bytes_left = 0;
        qh_memfreeshort(&qh_, &long_left, &bytes_left);
    }
    Qhull(const Qhull&) = delete;
    Qhull& operator=(const Qhull&) = delete;

    /// The faces, with numbers of the body's vertices as corners.
    std::vector<Face> faces()
    {
        if (failed_) throw std::runtime_error("Qhull failed");
        std::vector<Face> found;
        qhT* qh = &qh_; // Qhull's macros need this name.
        facetT* facet;
        vertexT *vertex, **vertexp;
        FORALLfacets
        {
            Face face{{facet->normal[0], facet->normal[1], facet->normal[2]}, -facet->offset, {}};
            FOREACHvertex_(facet->vertices) face.corners.push_back(qh_pointid(qh, vertex->point));
            sort_around(face);
            found.push_back(std::move(face));
        }
        return found;
    }

private:
    /// Sorts a face's corners by their angles around its middle.
    void sort_around(Face& face) const
    {
        using Map = Eigen::Map<const Eigen::Vector3d>;
        const auto point = [&](int corner) { return Map(coordinates_.data() + 3 * corner); };
        const Eigen::Vector3d normal = Map(face.normal.data()), x = normal.unitOrthogonal(), y = normal.cross(x);
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const int corner : face.corners) middle += point(corner) / double(face.corners.size());
        const auto angle = [&](int corner) {
            const Eigen::Vector3d to = point(corner) - middle;
            return std::atan2(y.dot(to), x.dot(to));
        };
        std::sort(face.corners.begin(), face.corners.end(), [&](int p, int q) { return angle(p) < angle(q); });
    }

    std::unique_ptr<std::FILE, int (*)(std::FILE*)> quiet_{std::fopen("/dev/null", "w"), &std::fclose};
    std::vector<double> coordinates_;
    qhT qh_;
    bool failed_;
};

/// Throws if the vertices are in a plane.
inline Hull hull_of(const league_body& body)
{
    Hull hull{{}, Qhull(body).faces()};
    std::vector<int> place(body.vertex_count, -1);
    for (Face& face : hull.faces)
        for (int& corner : face.corners) {
            int& where = place.at(std::size_t(corner));
            if (where < 0) {
                const double* p = body.vertices + 3 * corner;
                where = int(hull.points.size());
                hull.points.push_back({p[0], p[1], p[2]});
            }
            corner = where;
        }
    return hull;
}

#endif

} // namespace league
