#pragma once
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/rays/map_walk.hpp>
#include <oncollide/narrowphase/rays/ray_walk.hpp>
#include <oncollide/narrowphase/rays/segment_entry.hpp>
#include <oncollide/narrowphase/rays/segment_walk.hpp>
#include <oncollide/narrowphase/rays/terrain_walk.hpp>

namespace oncollide {

/// The first point of a segment in a model, in the model's frame.
struct SegmentHit {
    SegmentEntry entry;
    BodyPart part;          ///< the smallest of the parts whose entries may be the first
    Eigen::Vector3d normal; ///< normal of the part, unit, facing the segment's first point; 0: not defined
};

/// Tests segments against models. One thread's working memory.
class SegmentQuery {
public:
    /// True if meets() covers models of this kind.
    static bool covers(Kind kind) { return kind != Kind::round && kind != Kind::half_space; }

    /// True if meets() needs the model's OBB tree.
    static bool needs_tree(Kind kind) { return kind == Kind::mesh; }

    /// Colliding if meets(), or, with the kind `enclosed`, if the segment is inside the model; else separate, with a
    /// bound of 0.
    /// @param solid  the inside of a closed mesh belongs to the mesh
    Finding decide(Model& model, const Segment& segment, bool solid);

    /// True if the segment has a point in common with the model: with a triangle, or with a cell of a map, which is
    /// solid. Exact for the segment's coordinates in the model's frame. Throws ChunkFault.
    ///
    /// If a box or a hull has no OBB tree, its triangles are all tested.
    bool meets(Model& model, const Segment& segment);

    /// The first point of the segment in a model of any kind, if its fraction may be at most `reach`. There is one
    /// where decide() finds a collision. A mesh must have its OBB tree. Throws ChunkFault.
    std::optional<SegmentHit> first(Model& model, const Segment& segment, bool solid, double reach = 1);

private:
    struct Candidate {
        SegmentEntry entry;
        BodyPart part;
        std::uint32_t number; ///< number of the triangle in the tree
    };
    bool begins_inside(Model& model, const Segment& segment, bool solid);
    template <class Tree, class Entry>
    std::optional<Candidate> nearest(auto& walk, auto& walked, const Tree& tree, const Segment& segment, double reach,
                                     Entry entry);
    std::optional<Candidate> nearest_candidate(double reach) const;
    void add(const std::optional<SegmentEntry>& entry, const BodyPart& part, std::uint32_t number, double& reach);
    template <class Tree, class Meets>
    bool any(auto& walk, Tree& tree, const Segment& segment, Meets meets);
    bool meets_surface(Model& model, ObbTree& tree, const Segment& segment);
    std::optional<SegmentHit> first_on_surface(Model& model, const Segment& segment, double reach);

    RayWalk rays_;
    SegmentWalk<ObbTree> meshes_;
    SegmentWalk<TerrainTree> terrains_;
    SegmentWalk<MapTree> maps_;
    PointLocator locator_;
    std::vector<Candidate> candidates_;
};

} // namespace oncollide
