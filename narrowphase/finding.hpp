#pragma once
#include <compare>
#include <cstdint>
#include <limits>
#include <string_view>

#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

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
    std::uint32_t triangle = 0; ///< number of the triangle; 0 if the part is none
    MapCell cell{0, 0, 0, 0};   ///< side 0 if the part is no cell

    BodyPart() = default;
    BodyPart(std::uint32_t number) : triangle(number) {}
    BodyPart(const MapCell& cube) : cell(cube) {}
    friend auto operator<=>(const BodyPart&, const BodyPart&) = default;
};

} // namespace oncollide
