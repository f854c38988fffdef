#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

#ifdef near // a macro of <windows.h>
#undef near
#endif

namespace oncollide {

// The results of tests of two bodies.

/// The certain result of a pair of bodies at the end of a frame.
enum class Verdict : std::uint8_t {
    separate,  ///< distance > clearance, and at least the bound
    within,    ///< distance <= the bound; the bodies may or may not collide
    colliding, ///< the exact level found intersecting triangles, or one solid body encloses the other
    undecided, ///< a budget or a skipped stage stopped refinement; distance <= the bound reached so far
};

constexpr std::string_view name_of(Verdict verdict)
{
    constexpr std::string_view names[] = {"separate", "within", "colliding", "undecided"};
    return names[static_cast<int>(verdict)];
}

/// How a pair collides or is near, if an exact level decided it. Surfaces are compared by pairs of triangles, as in
/// TriangleContact.
enum class ContactKind : std::uint8_t {
    unknown,  ///< not determined, or there is no contact
    near,     ///< no contact; the distance is at most the clearance
    touching, ///< triangles meet, no two of them cross, and no point was found inside both
    crossing, ///< at least two triangles cross, or the insides of closed meshes overlap
    enclosed, ///< surfaces do not meet, and a part of one body is inside the other (solid mode)
};

constexpr std::string_view name_of(ContactKind kind)
{
    constexpr std::string_view names[] = {"unknown", "near", "touching", "crossing", "enclosed"};
    return names[static_cast<int>(kind)];
}

/// The certified result for one pair.
struct Finding {
    double bound = std::numeric_limits<double>::infinity(); ///< metres. separate: lower bound on the distance; within,
                                                            ///< undecided: upper bound on it; colliding: 0
    Verdict verdict = Verdict::undecided;
    ContactKind kind = ContactKind::unknown; ///< touching and crossing only if Settings::contact_kinds or
                                             ///< ignore_touching requests them

    constexpr Finding() = default;
    constexpr Finding(Verdict found, ContactKind of_kind, double certified)
        : bound(certified), verdict(found), kind(of_kind)
    {
    }
    friend constexpr bool operator==(const Finding&, const Finding&) = default;
};

/// A part of a body: a triangle of a mesh or terrain, or an occupied cube of a map, as large as the octree stores it. A
/// shape is one part.
struct BodyPart {
    std::uint32_t triangle = 0; ///< number of the triangle; 0 if the part is not a triangle
    MapCell cell{0, 0, 0, 0};   ///< side 0 if the part is not a cell

    BodyPart() = default;
    BodyPart(std::uint32_t number) : triangle(number) {}
    BodyPart(const MapCell& cube) : cell(cube) {}
    friend auto operator<=>(const BodyPart&, const BodyPart&) = default;
};

/// Two parts that meet, one of body a and one of body b. World frame, metres.
struct Contact {
    BodyPart a, b;
    /// Two triangles: touching or crossing. Other parts: unknown if they certainly meet (touching included), near if
    /// rounding prevents a decision. The rounding is 2^-47 of the bodies' sizes and distance; it matters only for
    /// rotated spheres, for spheres against round shapes, and for round shapes.
    ContactKind kind = ContactKind::unknown;
    /// Two triangles: the ends of the segment that both share, equal for a point. Other parts: a point on each; the two
    /// points differ only by rounding.
    std::array<Eigen::Vector3d, 2> ends{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    /// Unit normals. A triangle has its own normal; without an area, 0 or the opposite of a solid's normal. A cell or a
    /// shape has the outward normal of its surface at the point nearest to `ends` (an ellipsoid nearly), or the
    /// opposite of the other part's normal if the point is the centre of a sphere, a capsule or an ellipsoid.
    Eigen::Vector3d normal_a = Eigen::Vector3d::Zero(), normal_b = Eigen::Vector3d::Zero();

    Eigen::Vector3d middle() const { return 0.5 * (ends[0] + ends[1]); }
};

/// How closely a distance is measured, and up to where.
struct DistanceOptions {
    double tolerance = 0; ///< metres, >= 0: how far apart the bounds may be, besides rounding
    /// Metres, >= 0: if the two are farther apart, only a lower bound above it is found.
    double cutoff = std::numeric_limits<double>::infinity();
};

/// How far apart two bodies are.
struct Distance {
    double lower = 0, upper = std::numeric_limits<double>::infinity(); ///< certified bounds, metres; both 0 where they
                                                                       ///< meet; upper infinite if it was not requested
    BodyPart a{},
        b{}; ///< two parts that are at most `upper` apart, where that is finite; the first where solids overlap
    /// The two nearest points in the world frame, if `upper` is finite. They lie on the bodies and are `upper` apart,
    /// to rounding and the tolerance. If the bodies meet, both are one common point.
    Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
};

/// How deep two bodies penetrate each other: how far the deepest point of one lies inside the other, from its surface.
/// World frame, metres. Shapes, cells of maps and closed meshes have an inside in every mode; a terrain is solid below
/// its surface, and its points are the points of the surface.
struct Penetration {
    /// False for two terrains, and if one side is a cooked mesh that is read on demand; then nothing else is set.
    bool supported = true;
    /// Certified bounds of the depth; both 0 where the bodies are apart. For two bodies with triangles (meshes, boxes,
    /// hulls) `depth` is the depth of a vertex, and no vertex is deeper by more than 1 %. The bounds are equal, to
    /// rounding, for a half-space, and for a sphere or a capsule whose core is outside the other body.
    double depth = 0, depth_upper = 0;
    Eigen::Vector3d deepest = Eigen::Vector3d::Zero(); ///< a point that is `depth` deep, if that is > 0
    bool of_a = true;                                  ///< true if it is a point of body a
    // The rest is set for two bodies with triangles; for others it is empty, 0 or infinite.
    /// Around the points that both surfaces share, the contact curve; empty where they do not meet.
    Aabb contact;
    /// Around these points and all vertices of one body inside the other: around the overlap of two closed bodies.
    Aabb overlap;
    std::uint32_t vertex = 0; ///< number of the deepest vertex in its mesh
    /// The overlap of two closed bodies lies between two planes this far apart, to rounding; infinite if a body is not
    /// closed. It is the smallest of the tested distances: along the axes and some of the normals.
    double thickness = std::numeric_limits<double>::infinity();
    Eigen::Vector3d thin_along = Eigen::Vector3d::Zero(); ///< unit: across these planes
    /// For two shapes, of which one may be a half-space: the least translation that parts them, which other libraries
    /// call the penetration depth. Certified bounds of its length: both 0 where they are apart, and otherwise less than
    /// 1 % apart, with rare exceptions; its direction is unit, from a to b. Others: 0, infinite, and 0.
    double parting_lower = 0, parting_upper = std::numeric_limits<double>::infinity();
    Eigen::Vector3d parting_along = Eigen::Vector3d::Zero();
};

/// Which contact ends a sweep.
enum class SweepStop : std::uint8_t {
    contact, ///< the first certain contact; a gap that rounding hides does not end the sweep
    touch,   ///< the first time at which the bodies may touch; a gap that rounding hides ends the sweep, too
    press,   ///< the first contact deeper than the gap tolerance; before it, bodies may touch, slide along each other,
             ///< and part
};

constexpr std::string_view name_of(SweepStop stop)
{
    constexpr std::string_view names[] = {"contact", "touch", "press"};
    return names[static_cast<int>(stop)];
}

/// How closely a sweep brackets the first contact.
struct SweepOptions {
    double time_tolerance = 1e-4; ///< bounds contact_by - grazes_until; at least 1e-12
    double gap_tolerance = 1e-4;  ///< metres; bounds the distance at clear_until; at least 1e-12
    int most_steps = 10000;       ///< windows of time to examine; at least 1. After them the pair stays `undecided`
    SweepStop stop = SweepStop::contact;
};

/// When two moving bodies first meet. Their motions last from time 0 to time 1.
struct SweepResult {
    /// separate: they never come within the clearance. colliding, or within with kind `near`: at contact_by they meet,
    /// or come within the clearance, as decide() finds at these poses; never earlier than at clear_until. within with
    /// kind `unknown`: at contact_by they are at most `gap` apart, and no contact that ends the sweep was found until
    /// grazes_until; after it nothing is known. undecided: the limit of steps was reached, rounding leaves a gap above
    /// its tolerance, or a file could not be read; after clear_until nothing is known.
    Verdict verdict = Verdict::undecided;
    ContactKind kind = ContactKind::unknown;
    /// Certified: they do not meet, or come within the clearance, at any earlier time. 1 if they never do.
    double clear_until = 0;
    /// At least clear_until, and at most the time tolerance before a certain contact. From clear_until on, the bodies
    /// graze until this time: they may touch, but do not get deeper into each other than the gap tolerance, where they
    /// are thicker than that. With SweepStop::contact, none of the poses that were tested collides.
    double grazes_until = 0;
    double contact_by = std::numeric_limits<double>::infinity(); ///< infinite: there is no contact
    /// Upper bound on the distance at clear_until, without the clearance; infinite: not known.
    double gap = std::numeric_limits<double>::infinity();
    bool separating = false; ///< contact at time 0: they are apart after the time tolerance
    int steps = 0;           ///< windows of time that were examined
    /// At contact_by, world frame: two parts that meet, or, where only a clearance or rounding is between them, come
    /// near; not set for kind `enclosed`.
    Contact contact{};
    /// Unit, from a to b, world frame: it separates the bodies just before the contact; 0: not known, as for a contact
    /// at time 0.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

// --- Manifolds: contacts reduced for a solver.

/// How two bodies meet in a region.
enum class RegionKind : std::uint8_t {
    crossing, ///< the surfaces cross around a common volume
    touching, ///< they meet without a common volume: in points, segments or areas of a plane
    enclosed, ///< a part of one body is inside the other, and the surfaces do not meet there
    near,     ///< no contact, and at most ManifoldOptions::margin apart
};

constexpr std::string_view name_of(RegionKind kind)
{
    constexpr std::string_view names[] = {"crossing", "touching", "enclosed", "near"};
    return names[static_cast<int>(kind)];
}

/// A vertex, an edge or a face of a body, as bits: equal features of a model have equal bits in every query. The two
/// highest bits are 1, 2 or 3 for a vertex, an edge or a face. The vertices of a mesh at one position are one feature.
/// A round shape is one face, number 0.
using FeatureBits = std::uint64_t;

enum class FeatureKind : std::uint8_t { none, vertex, edge, face };
constexpr FeatureKind kind_of(FeatureBits feature)
{
    return static_cast<FeatureKind>(feature >> 62);
}
/// The number of a mesh's vertex, of a terrain's, row by row, or of the first triangle of a face.
constexpr std::uint64_t number_of(FeatureBits feature)
{
    return feature & ~(std::uint64_t{3} << 62);
}
/// The numbers of the vertices of an edge, the smaller one first. Not for maps, nor for 2^31 vertices or more.
constexpr std::array<std::uint32_t, 2> edge_vertices(FeatureBits edge)
{
    constexpr std::uint32_t number = 0x7fffffff;
    return {static_cast<std::uint32_t>(edge >> 31) & number, static_cast<std::uint32_t>(edge) & number};
}

/// One point of a region. World frame, metres.
struct ManifoldPoint {
    Eigen::Vector3d point_a, point_b; ///< on body a and on body b, `depth` apart along the region's normal
    double depth;                     ///< from point_b to point_a along the normal: > 0 inside, < 0 apart
    double depth_error;               ///< certified: this bounds the error of the depth
    FeatureBits feature_a, feature_b;
    /// Unit, from a to b. Where faces of both bodies are opposite each other at the point, it is normal to these faces;
    /// at the end of a region, normal to the body's own face; elsewhere, and in flat regions, it is the region's
    /// normal. It differs from the region's normal by at most 45 degrees. Threads and bearings turn on these.
    Eigen::Vector3d normal;
};

/// A connected part of where two bodies meet. World frame, metres.
struct ManifoldRegion {
    RegionKind kind;
    bool open;              ///< a surface is not closed; near it, the space behind it counts as inside
    Eigen::Vector3d normal; ///< unit, from a to b: moving b along it parts the bodies
    /// Bound of the angle to the exact normal, radians; pi where no normal has a meaning. The exact normal of two
    /// shapes is a direction of the least translation that parts them, or, where that is less than 1 % longer, of a
    /// face.
    double normal_error;
    /// Area of the contact across the normal; volume of the overlap. 0: not known, as for two shapes of which one is
    /// round. These, `centre` and `lost` are NaN without
    /// ManifoldOptions::measures.
    double area, volume;
    Eigen::Vector3d centre; ///< centre of the area
    /// Certified. A point of one body is in the other until b has moved by `depth_lower` along the normal. Once it has
    /// moved by `depth_upper`, the two surfaces of the region are on the two sides of a plane. For two shapes, no
    /// translation shorter than `depth_lower` parts them in any direction.
    double depth_lower, depth_upper;
    double lost; ///< no common point of both surfaces of the region is farther than this from the hull of its points
    std::uint32_t first, count; ///< its points
    std::uint32_t found;        ///< number of candidates from which these points were chosen
};

/// Limits of a manifold.
struct ManifoldOptions {
    double margin = 0;                        ///< metres: parts of surfaces this near are regions, too
    double normal_spread = 0.174532925199433; ///< radians: faces of one region differ by at most twice this
    std::uint32_t points_per_region = 4, regions_per_pair = 16; ///< at least 1
    std::uint32_t points_per_pair = 64; ///< at least 1; regions share them in turn, the deepest region first
    /// Points of all pairs of one call of Pairs::manifold(). Pairs share the points in turn, the deepest pair first.
    /// 0: no limit.
    std::uint32_t points_in_all = 0;
    bool measures = false; ///< find the regions' area, volume, centre and `lost`, which solvers do not use

    friend bool operator==(const ManifoldOptions&, const ManifoldOptions&) = default;
};

/// The manifold of one pair.
struct Manifold {
    std::vector<ManifoldRegion> regions; ///< the deepest first
    std::vector<ManifoldPoint> points;
    /// False if a limit left out a region or a point. False also for two half-spaces and for cooked meshes that are
    /// read on demand, which have no manifold.
    bool complete = true;
};

/// Two features that are near each other.
struct NearFeatures {
    FeatureBits a, b;
    double lower, upper;              ///< certified bounds of their distance, metres
    Eigen::Vector3d point_a, point_b; ///< their nearest points, world frame
};

/// Features of one mesh that are neighbours, and so no near features of each other.
struct SelfNearOptions {
    /// Features that fewer edges of the mesh connect are neighbours; at least 1. With 1 they share a vertex, with 2
    /// also if an edge is between them.
    std::uint32_t rings = 1;
    /// The positions of the vertices in a rest shape; empty: there is none. Features that are at most `rest_distance`
    /// (metres) apart there are neighbours, too, up to rounding.
    std::span<const Eigen::Vector3d> rest{};
    double rest_distance = 0;
};

} // namespace oncollide
