#pragma once
#include <oncollide/narrowphase/listed_surfaces.hpp>
#include <oncollide/narrowphase/triangle_set.hpp>
#include <oncollide/narrowphase/walk.hpp>
#include <oncollide/narrowphase/walk_kernel.hpp>

namespace oncollide {

/// Moves points of B into A's frame, in double: what the exact level calls their coordinates. One place, for all who
/// ask must get the same bits.
struct IntoA {
    Eigen::Matrix3d turn;
    Eigen::Vector3d shift;

    IntoA(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
        : turn(a.linear().transpose() * b.linear()), shift(a.linear().transpose() * (b.translation() - a.translation()))
    {
    }
    Eigen::Vector3d operator()(const Eigen::Vector3d& p) const { return turn * p + shift; }
};

/// Two meshes' triangles in the leaves of their trees, by exact predicates on the file's own coordinates: those of B
/// are moved into A's frame in double, and for the coordinates so rounded the answer is exact. Touching counts.
class MeshLeafTest final : public LeafTest {
public:
    /// Keeps both references. Trees are numbered as the scene's geometries; only meshes may be asked about.
    MeshLeafTest(const Scene& scene, const ListedSurfaces& lists) : scene_(scene), lists_(lists) {}

    std::unique_ptr<Scratch> make_scratch() const override;
    /// Of the triangles of all the leaves together: the pair named is one near where two of them meet.
    /// Cost: about 20 ns a triangle and 1 ns a pair of triangles whose boxes are apart.
    std::size_t first_meeting(const WalkPair& pair, std::span<const LeafKeys> leaves, Scratch& scratch) const override;
    /// Appends all pairs of triangles that meet in the leaves, by number in their meshes; some more than once.
    void all_meeting(const WalkPair& pair, std::span<const LeafKeys> leaves, Scratch& scratch,
                     std::vector<TriangleMeeting>& out) const;

private:
    struct Memory;
    bool gather(const WalkPair& pair, std::span<const LeafKeys> leaves, Memory& memory) const;

    const Scene& scene_;
    const ListedSurfaces& lists_;
};

/// Finds every two triangles that meet: lets no pair of leaves end the walk.
class AllMeeting final : public LeafTest {
public:
    /// Keeps both references. For one walk on one thread.
    AllMeeting(const MeshLeafTest& test, std::vector<TriangleMeeting>& pairs) : test_(test), pairs_(pairs) {}

    std::unique_ptr<Scratch> make_scratch() const override { return test_.make_scratch(); }
    std::size_t first_meeting(const WalkPair& pair, std::span<const LeafKeys> leaves, Scratch& scratch) const override
    {
        test_.all_meeting(pair, leaves, scratch, pairs_);
        return leaves.size();
    }
    void finish() const; ///< after the walk: sorts the pairs, each once

private:
    const MeshLeafTest& test_;
    std::vector<TriangleMeeting>& pairs_;
};

} // namespace oncollide
