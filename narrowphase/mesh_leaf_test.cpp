#include <oncollide/narrowphase/mesh_leaf_test.hpp>

#include <algorithm>
#include <array>
#include <limits>

#include <immintrin.h>

#include <oncollide/scenes/error.hpp>

namespace oncollide {

namespace {

/// A box in the frame of a tree, relative to its root's centre.
struct Region {
    __m128 low, high;

    void add(const Region& other) { low = _mm_min_ps(low, other.low), high = _mm_max_ps(high, other.high); }
    bool reached_by(const Primitive& p) const
    {
        const __m128 a = _mm_load_ps(p.point[0]), b = _mm_load_ps(p.point[1]), c = _mm_load_ps(p.point[2]);
        const __m128 apart = _mm_or_ps(_mm_cmpgt_ps(_mm_min_ps(_mm_min_ps(a, b), c), high),
                                       _mm_cmplt_ps(_mm_max_ps(_mm_max_ps(a, b), c), low));
        return !(_mm_movemask_ps(apart) & 7);
    }
};

Region around(const Eigen::Vector3d& centre, double radius)
{
    const Eigen::Vector3f c = centre.cast<float>();
    const __m128 middle = _mm_setr_ps(c.x(), c.y(), c.z(), 0), reach = _mm_set1_ps(static_cast<float>(radius));
    return {_mm_sub_ps(middle, reach), _mm_add_ps(middle, reach)};
}

/// The leaves of one side that take part in a batch, each once.
class Cells {
public:
    struct Cell {
        std::uint32_t parent, octant;
        Region own;     ///< around it, in the frame of the other side
        Region touched; ///< around the leaves of the other side that it touches, in its own frame
    };

    void start()
    {
        cells_.clear();
        if (++batch_ == 0) slots_.fill({}), batch_ = 1;
    }
    /// @param region_of  makes the cell's own region when it is new
    template <class RegionOf>
    Cell& get(std::uint32_t parent, CellKey key, RegionOf region_of)
    {
        const unsigned octant = octant_of(key);
        for (std::uint32_t at = (parent * 8 + octant) * 0x9e3779b1u >> 22;; at = (at + 1) % slots_.size()) {
            Slot& slot = slots_[at];
            if (slot.batch != batch_) {
                slot = {batch_, static_cast<std::uint32_t>(cells_.size())};
                cells_.push_back({parent, octant, region_of(key, parent), nowhere()});
                return cells_.back();
            }
            Cell& cell = cells_[slot.cell];
            if (cell.parent == parent && cell.octant == octant) return cell;
        }
    }
    std::span<const Cell> all() const { return cells_; }

private:
    struct Slot {
        std::uint32_t batch = 0, cell = 0;
    };
    static Region nowhere()
    {
        const __m128 far = _mm_set1_ps(std::numeric_limits<float>::infinity());
        return {far, _mm_sub_ps(_mm_setzero_ps(), far)};
    }
    std::array<Slot, 1024> slots_{}; ///< three times as many as there can be cells
    std::uint32_t batch_ = 0;
    std::vector<Cell> cells_;
};

/// Some triangles of one mesh, each once.
struct Gathered {
    std::vector<std::uint32_t> ids;
    std::vector<TrianglePoints> points;
    std::vector<std::uint32_t> seen; ///< by triangle: the call that last met it
    std::uint32_t call = 0;

    void start(std::size_t triangles)
    {
        ids.clear(), points.clear();
        if (seen.size() < triangles || ++call == 0) seen.assign(std::max(seen.size(), triangles), 0), call = 1;
    }

    /// Those of a list that reach a region.
    void add(const TriangleSpan& span, const Surface& surface, const Region& region)
    {
        for (std::uint32_t i = 0; i < span.count; ++i) {
            if (span.ids && !(span.masks[i] >> span.octant & 1)) continue;
            const std::uint32_t id = span.ids ? span.ids[i] : i;
            if (seen[id] == call || !region.reached_by(surface.primitives[id])) continue;
            seen[id] = call;
            ids.push_back(id);
        }
    }

    template <class Place>
    void take(const Mesh& mesh, Place place)
    {
        for (std::uint32_t id : ids) {
            const Triangle& t = mesh.triangles[id];
            points.push_back({place(mesh.vertices[t[0]]), place(mesh.vertices[t[1]]), place(mesh.vertices[t[2]])});
        }
    }
};

/// The ball around the surface in a leaf, relative to the root's centre.
struct LeafBall {
    Eigen::Vector3d centre;
    double radius;

    LeafBall(const Ocst& tree, CellKey cell, std::uint32_t parent)
    {
        const double size = 1.0 / double(1ull << level_of(cell));
        const auto place = centre_of(cell);
        const TightBlock* const tight = level_of(cell) <= tree.tight_levels() ? tree.tight() : nullptr;
        const unsigned k = octant_of(cell);
        const std::int8_t plain[3] = {0, 0, 0};
        const std::int8_t moved[3] = {tight ? tight[parent].x[k] : plain[0], tight ? tight[parent].y[k] : plain[1],
                                      tight ? tight[parent].z[k] : plain[2]};
        for (int axis = 0; axis < 3; ++axis)
            centre[axis] =
                (place[std::size_t(axis)] + moved[axis] / 127.0) * size * double(tree.root().half[std::size_t(axis)]);
        radius = tree.root().radius * size * (tight ? tight[parent].r[k] / 255.0 : 1.0);
    }
};

} // namespace

struct MeshLeafTest::Memory final : Scratch {
    Cells cells_a, cells_b;
    Gathered a, b;
    TriangleSet set; ///< of a's
    std::vector<TriangleMeeting> found;
};

std::unique_ptr<LeafTest::Scratch> MeshLeafTest::make_scratch() const
{
    return std::make_unique<Memory>();
}

/// The triangles of each leaf that reach the leaves it touches. False when there are none on one side.
bool MeshLeafTest::gather(const WalkPair& pair, std::span<const LeafKeys> leaves, Memory& memory) const
{
    const auto mesh_of = [&](std::uint32_t tree) -> const Mesh& {
        return std::get<Mesh>(scene_.geometries[tree].data);
    };
    const Mesh &mesh_a = mesh_of(pair.tree_a), &mesh_b = mesh_of(pair.tree_b);
    const Surface &surface_a = lists_.surface(pair.tree_a), &surface_b = lists_.surface(pair.tree_b);
    const Ocst &tree_a = *pair.a, &tree_b = *pair.b;
    const IntoA into_a(*pair.pose_a, *pair.pose_b);
    const Eigen::Matrix3d& turn = into_a.turn;
    const Eigen::Vector3d between = into_a(tree_b.root().centre) - tree_a.root().centre;
    // As in the walk: poses may be 2^-20 from rigid; and the surfaces' floats.
    const double rounding = 0x1p-17 * (between.norm() + tree_a.radius(0) + tree_b.radius(0));

    const auto region_of_a = [&](CellKey key, std::uint32_t parent) {
        const LeafBall ball(tree_a, key, parent);
        return around(turn.transpose() * (ball.centre - between), ball.radius + rounding);
    };
    const auto region_of_b = [&](CellKey key, std::uint32_t parent) {
        const LeafBall ball(tree_b, key, parent);
        return around(turn * ball.centre + between, ball.radius + rounding);
    };
    memory.cells_a.start(), memory.cells_b.start();
    for (const LeafKeys& leaf : leaves) {
        Cells::Cell& a = memory.cells_a.get(leaf.parent_a, leaf.a, region_of_a);
        Cells::Cell& b = memory.cells_b.get(leaf.parent_b, leaf.b, region_of_b);
        a.touched.add(b.own), b.touched.add(a.own);
    }
    memory.a.start(mesh_a.triangles.size()), memory.b.start(mesh_b.triangles.size());
    for (const Cells::Cell& cell : memory.cells_a.all())
        memory.a.add(lists_.span_of(pair.tree_a, tree_a.list(cell.parent), cell.octant), surface_a, cell.touched);
    for (const Cells::Cell& cell : memory.cells_b.all())
        memory.b.add(lists_.span_of(pair.tree_b, tree_b.list(cell.parent), cell.octant), surface_b, cell.touched);
    if (memory.a.ids.empty() || memory.b.ids.empty()) return false;
    memory.a.take(mesh_a, [](const Eigen::Vector3d& p) -> const Eigen::Vector3d& { return p; });
    memory.b.take(mesh_b, into_a);
    memory.set.assign(memory.a.points);
    return true;
}

std::size_t MeshLeafTest::first_meeting(const WalkPair& pair, std::span<const LeafKeys> leaves, Scratch& scratch) const
{
    auto& memory = static_cast<Memory&>(scratch);
    if (!gather(pair, leaves, memory)) return leaves.size();
    const auto meeting = memory.set.first_meeting(memory.b.points);
    if (!meeting) return leaves.size();
    const auto in = [&](const TriangleSpan& span, std::uint32_t id) {
        if (!span.ids) return true;
        const std::uint32_t* const at = std::find(span.ids, span.ids + span.count, id);
        return at != span.ids + span.count && (span.masks[at - span.ids] >> span.octant & 1);
    };
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const LeafKeys& leaf = leaves[i];
        if (in(lists_.span_of(pair.tree_b, pair.b->list(leaf.parent_b), octant_of(leaf.b)), memory.b.ids[meeting->a]) &&
            in(lists_.span_of(pair.tree_a, pair.a->list(leaf.parent_a), octant_of(leaf.a)), memory.a.ids[meeting->b]))
            return i;
    }
    return 0;
}

void MeshLeafTest::all_meeting(const WalkPair& pair, std::span<const LeafKeys> leaves, Scratch& scratch,
                               std::vector<TriangleMeeting>& out) const
{
    auto& memory = static_cast<Memory&>(scratch);
    if (!gather(pair, leaves, memory)) return;
    memory.set.all_meeting(memory.b.points, memory.found);
    for (TriangleMeeting m : memory.found) out.push_back({memory.a.ids[m.b], memory.b.ids[m.a]});
}

void AllMeeting::finish() const
{
    const auto order = [](TriangleMeeting x, TriangleMeeting y) { return x.a < y.a || (x.a == y.a && x.b < y.b); };
    std::sort(pairs_.begin(), pairs_.end(), order);
    pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
}

} // namespace oncollide
