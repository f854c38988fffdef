// libccd alone: convex bodies as support functions.
#include <algorithm>

#include <ccd/ccd.h>
#include <ccd/quat.h>

#include "common.hpp"

namespace {

using league::Vector;

/// The point of a body, in its own frame, that is farthest in direction d.
Vector farthest(const league_body& body, const Vector& d)
{
    const double* size = body.size;
    const double around = std::hypot(d[0], d[1]), length = std::hypot(around, d[2]);
    const auto up = [&](double z) { return d[2] >= 0 ? z : -z; };
    const auto rim = [&](double z) {
        return around > 0 ? Vector{size[0] * d[0] / around, size[0] * d[1] / around, z} : Vector{0, 0, z};
    };
    switch (body.kind) {
    case LEAGUE_SPHERE:
    case LEAGUE_CAPSULE: {
        const double scale = length > 0 ? size[0] / length : 0;
        return {scale * d[0], scale * d[1], scale * d[2] + (body.kind == LEAGUE_CAPSULE ? up(size[1]) : 0)};
    }
    case LEAGUE_BOX:
        return {std::copysign(size[0], d[0]), std::copysign(size[1], d[1]), up(size[2])};
    case LEAGUE_CYLINDER:
        return rim(up(size[1]));
    case LEAGUE_CONE: // the tip, if it is farther than the base's edge
        return 2 * size[1] * d[2] > size[0] * around ? Vector{0, 0, size[1]} : rim(-size[1]);
    case LEAGUE_ELLIPSOID: {
        const Vector scaled{size[0] * d[0], size[1] * d[1], size[2] * d[2]};
        const double scale = league::length_of(scaled);
        if (!(scale > 0)) return {size[0], 0, 0};
        return {size[0] * scaled[0] / scale, size[1] * scaled[1] / scale, size[2] * scaled[2] / scale};
    }
    default: { // a hull
        const double* best = body.vertices;
        double most = -HUGE_VAL;
        for (const double *p = body.vertices, *end = p + 3 * body.vertex_count; p != end; p += 3)
            if (const double far = d[0] * p[0] + d[1] * p[1] + d[2] * p[2]; far > most) most = far, best = p;
        return {best[0], best[1], best[2]};
    }
    }
}

struct Shape {
    league_body body;
    ccd_vec3_t centre;

    explicit Shape(const league_body& given) : body(given)
    {
        const bool is_hull = body.kind == LEAGUE_HULL;
        const Vector c = league::to_world(body, is_hull ? league::mean_vertex(body) : Vector{});
        ccdVec3Set(&centre, c[0], c[1], c[2]);
    }
};

void support(const void* shape, const ccd_vec3_t* direction, ccd_vec3_t* point)
{
    const league_body& body = static_cast<const Shape*>(shape)->body;
    const Vector d = league::to_body_direction(body, {direction->v[0], direction->v[1], direction->v[2]});
    const Vector p = league::to_world(body, farthest(body, d));
    ccdVec3Set(point, p[0], p[1], p[2]);
}

void centre(const void* shape, ccd_vec3_t* point)
{
    *point = static_cast<const Shape*>(shape)->centre;
}

using Intersect = int(const void*, const void*, const ccd_t*);
using Penetration = int(const void*, const void*, const ccd_t*, ccd_real_t*, ccd_vec3_t*, ccd_vec3_t*);

template <Intersect& intersect, Penetration& penetration>
struct Pair final : league::Query {
    Shape a, b;
    ccd_t ccd;

    explicit Pair(const league_case& asked) : a(asked.a), b(asked.b)
    {
        CCD_INIT(&ccd);
        ccd.support1 = ccd.support2 = support;
        ccd.center1 = ccd.center2 = centre;
        ccd.max_iterations = 100;
        ccd.epa_tolerance = 1e-10; // With its default, 1e-4, depths of round bodies are wrong by up to 1e-2.
    }

    int answer(const league_case& asked, league_answer& answer) override
    {
        if (asked.question == LEAGUE_MEET) {
            answer.meet = intersect(&a, &b, &ccd) != 0;
            return LEAGUE_ANSWERED;
        }
        ccd_vec3_t direction, place;
        const int result = penetration(&a, &b, &ccd, &answer.depth, &direction, &place);
        if (result == -2) return LEAGUE_FAILED;
        answer.meet = result == 0;
        if (answer.meet)
            std::copy_n(direction.v, 3, answer.normal);
        else
            answer.depth = 0;
        return LEAGUE_ANSWERED;
    }
};

int supports(int question, int kind_a, int kind_b)
{
    return (question == LEAGUE_MEET || question == LEAGUE_DEPTH) && league::is_convex(kind_a) &&
           league::is_convex(kind_b);
}

constexpr league_library libraries[] = {
    league::library_of<league::make<Pair<ccdGJKIntersect, ccdGJKPenetration>>>({
        .name = "ccd",
        .settings = "2.1; ccdGJKIntersect(), ccdGJKPenetration() (EPA); at most 100 iterations, epa_tolerance 1e-10",
        .source = "ccd/ccd.h, README.md of libccd",
        .supports = supports,
        .precision = 1e-4,
    }),
    league::library_of<league::make<Pair<ccdMPRIntersect, ccdMPRPenetration>>>({
        .name = "ccd-mpr",
        .settings = "2.1; ccdMPRIntersect(), ccdMPRPenetration(); at most 100 iterations, default mpr_tolerance 1e-4",
        .source = "ccd/ccd.h, README.md of libccd",
        .supports = supports,
        .precision = 1e-4, // mpr_tolerance
    }),
};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
