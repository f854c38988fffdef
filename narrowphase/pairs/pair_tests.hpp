#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/pair_memory.hpp>
#include <oncollide/narrowphase/pairs/pair_worker.hpp>
#include <oncollide/narrowphase/pairs/sweep.hpp>

namespace oncollide {

/// Whether the tests of a pair need the trees of the models that have triangles.
enum class TreesNeeded : std::uint8_t { never, for_kinds, always };

/// The tests of two kinds of models, one column for each question. A column is null if the question has no test for
/// these kinds. The trees that `trees` requires must exist. The tests throw ChunkFault if a file cannot be read.
struct PairTests {
    TreesNeeded trees;

    /// Exact: colliding if a common point is certain, else separate if a gap is certain. With a clearance, the distance
    /// decides the rest. Shapes and cells are solid. Pairs stay `within` if rounding (2^-47 of the bodies' sizes and
    /// distance, if a sphere or a capsule is rotated or another round shape takes part) or the error of a terrain's
    /// heights leaves both possible.
    /// @param memory  witness, tested first (except for two maps) and updated; null: no witness
    Finding (*decide)(PairWorker&, const PairTask&, const PairOptions&, PairMemory* memory);

    /// Within clearance + tolerance (metres), or separate. With an infinite tolerance, `separate` is certain if
    /// bounding boxes show it.
    Finding (*near)(PairWorker&, const PairTask&, double clearance, double tolerance, PairMemory* memory);

    /// As Pairs::distance(). Exception: for a box or a hull that encloses a map's cells or a part of a mesh, it may be
    /// the distance to its surface. Beyond the cutoff, the upper bound is infinite.
    /// @param solid  the inside of a closed mesh belongs to the mesh
    Distance (*distance)(PairWorker&, const PairTask&, const DistanceOptions&, bool solid);

    /// The same for pairs that need neither trees nor walks.
    Distance (*direct_distance)(const PairTask&, const DistanceOptions&);

    /// Appends contacts sorted by (a, b), each pair of parts once: exact where `decide` is. All pairs of cells, boxes,
    /// hulls and triangles with a common point are found, for one body's coordinates transformed into the other's frame
    /// in double. Contacts of round shapes that rounding cannot decide are reported as `near`. Cost: the cost of the
    /// exact level, plus half a microsecond to two per contact.
    void (*contacts)(PairWorker&, const PairTask&, std::vector<Contact>&);

    /// As Pairs::penetration(). Null: unsupported.
    Penetration (*penetration)(PairWorker&, const PairTask&);

    /// When the two first meet during their motions.
    SweepResult (*advance)(PairWorker&, const SweepTask&);
    /// As Pairs::manifold(). Null: unsupported.
    void (*manifold)(PairWorker&, const PairTask&, const ManifoldOptions&, Manifold&);

    /// Appends features as Pairs::near_features() does. Null: unsupported.
    void (*near_features)(PairWorker&, const PairTask&, double dhat, std::vector<NearFeatures>&);
};

/// PairTests::near()'s result for bodies that certainly overlap.
constexpr Finding bodies_overlap{Verdict::within, ContactKind::unknown, 0x1p-1000};

/// The tests of models of these kinds, in this order.
const PairTests& tests_for(Kind a, Kind b);
inline const PairTests& tests_for(const PairTask& task)
{
    return tests_for(task.a->kind(), task.b->kind());
}

} // namespace oncollide
