// The trials of `oncollide-lab hard`. Their pairs and sums do not depend on the number of threads.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "truth/setting_variants.hpp"
#include "truth/tally.hpp"
#include "verify/cases/body_case.hpp"
#include "verify/cases/near_families.hpp"

namespace oncollide::tools {

/// `count` pairs of a family, as stored on their grid of 2^-20 m, or randomly rotated and rounded. Compares the exact
/// test, in both orders of the triangles, with the oracle. Cost: 10 to 100 microseconds per pair.
Tally try_triangles(const TriangleFamily& family, std::uint64_t count, bool rotated, int threads);

/// `count` pairs of triangles of a family, as two meshes. Compares all lower and upper bounds with the exact distance:
/// of the kernels, decide() with and without clearance and error, distance(), near_features(), clear_until; and a live
/// World with a new one after moves by less and by more than the remembered gap. Cost: about 0.3 ms per pair.
Tally try_bounds(const NearFamily& family, std::uint64_t count, int threads);

constexpr const char* approach_family = "near bodies of all kinds";

/// `count` pairs of two bodies of all kinds, which approach each other to 1e-13 to 1e-2 m and then move by about the
/// gap that a World remembers: step() of a live World must say what decide() says, and distances must agree with
/// verdicts. Half of the bodies are upright or lean by 1e-15 to 1, where AABBs and roots of differences are easily
/// wrong. Cost: about 1 ms per pair.
Tally try_approaches(std::uint64_t count, int threads);

/// Families of spheres, capsules and triangles that touch cells and boxes.
constexpr const char* tangent_families[] = {"balls on faces of cells and boxes", "balls on edges of cells and boxes",
                                            "balls on corners of cells and boxes", "capsules along edges",
                                            "triangles on cells"};

/// `count` pairs of one of these families: a sphere, a capsule or a triangle, and a cell of a map, a box, a hull or a
/// mesh of a box, touching or one unit of the grid apart, at scales of 2^-30 to 2^30 m and up to 2^26 times as far from
/// the origin. Truth: squares of integers, and linear programming for triangles. Tests the exact level, both bounding
/// volumes without it, and FCL's exact level.
Tally try_tangent(const std::string& family, std::uint64_t count, int threads);

/// Families of bodies that touch terrains.
constexpr const char* terrain_families[] = {"balls on terrain",     "capsules on terrain",    "boxes on terrain",
                                            "triangles on terrain", "half-spaces on terrain", "terrain on terrain",
                                            "terrain that is off"};

/// `count` pairs of one of these families: a terrain of a few cells, and a body that touches a face, an edge or a
/// vertex of it, or is one unit of the grid or of the last place away: spheres, capsules, cells of maps, boxes, hulls,
/// meshes, half-spaces and terrains. At 1, 2, 4 and 8 bytes per height, with holes and both diagonals, 1e-9 to 1e9 m
/// large and up to 1e8 m from the origin. In the last family heights have an error, and bounds must hold for the given
/// heights. Truth: exact distances, and linear programming for polytopes.
Tally try_terrain(const std::string& family, std::uint64_t count, int threads);

/// A way to run the pipeline on a case.
struct Variant : SettingVariant {
    bool among_others = false; ///< with 70 static bodies far away, so that delimitation can reject something
    bool closed_alone = false; ///< only for cases in which a mesh has an inside
    double of_size = 0;        ///< the clearance, in diagonals of the larger body
    double of_distance = 0;    ///< or in multiples of the bodies' distance at the first pose where they are apart
};

/// No exact level, predicates and FCL with both bounding volumes: with each set of stages skipped, at two depths; with
/// other algorithms, budgets and more bodies; with small and large clearances, slightly below, at and above the
/// distance; as solids; and with kinds of contact requested.
std::vector<Variant> all_variants();

/// Runs every variant on the case in all its forms. Checks each verdict, kind and bound against the truth, and each
/// verdict against the verdict of the case as stored. A mesh without an inside must be refused as a solid, and is then
/// treated as a surface. A result of FCL may be wrong where FCL is wrong. Throws Error{internal} if the truth
/// contradicts the case.
Tally try_bodies(const BodyCase& c, const std::vector<Variant>& variants);

/// All bodies of all cases in one scene, as stored, each at its first pose. Most are near the origin, so bodies of one
/// case are hard for bodies of the others. The result hash must be equal for any number of threads and kind of broad
/// phase; with `gpu` also for gl-compute, in runs with spheres. The pair of each case must have the
/// same result as alone, also from Pairs::decide(). Throws Error{no_gpu} if `gpu` is requested
/// and there is none.
Tally try_crowd(const std::vector<BodyCase>& cases, Mode mode, std::span<const int> threads, bool gpu);

} // namespace oncollide::tools
