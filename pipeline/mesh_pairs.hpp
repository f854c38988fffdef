#pragma once
#include <optional>
#include <span>
#include <vector>

#include <oncollide/narrowphase/boxes/traversal.hpp>
#include <oncollide/narrowphase/exact/shared_inside.hpp>
#include <oncollide/pipeline/forest.hpp>
#include <oncollide/pipeline/frame.hpp>

namespace oncollide {

/// Asks many pairs of meshes at once, by their trees of oriented boxes, and remembers the triangles that met: next
/// frame they are tried first.
class MeshPairs {
public:
    explicit MeshPairs(Forest& forest) : forest_(forest) {}

    /// May the pair be asked? False when one is no mesh, or when a budget has no room for its tree.
    bool admit(const Scene& scene, const Frame& frame, BodyPair pair);

    struct Ask {
        BodyPair pair;
        Traversal::Nearness answer{}; ///< out
        TriangleContact contact{};    ///< out: of triangles that meet, where kinds are asked for
    };
    /// Are they near, by the clearance and the error that the settings allow?
    void near(const Scene& scene, Frame& frame, std::span<Ask> asks);
    /// Do they meet, exactly, and how, if the settings ask? With a clearance, those that do not but are within it are
    /// near, bounded by their distance.
    void meet(const Scene& scene, Frame& frame, std::span<Ask> asks);
    /// How far apart are they? As Traversal::distance(); found[i] for asks[i].
    void distances(const Scene& scene, const Frame& frame, std::span<const Ask> asks, double tolerance, double farthest,
                   std::vector<Traversal::Distance>& found);

private:
    struct Met {
        BodyPair pair;
        TrianglePair triangles;
    };
    void make_walks(int threads);
    template <class Answer>
    void run(const Scene& scene, Frame& frame, std::span<Ask> asks, Answer answer);
    bool closed(const Scene& scene, GeometryId geometry);
    void find_overlaps(const Scene& scene, const Frame& frame, std::span<Ask> asks);

    Forest& forest_;
    std::vector<Traversal> walks_;            ///< by thread
    std::vector<SharedInside> insides_;       ///< by thread
    std::vector<std::optional<bool>> closed_; ///< by geometry; nothing until a pair of it touches
    std::vector<Ask*> touching_;
    std::vector<Met> met_; ///< last frame's, sorted by pair
};

} // namespace oncollide
