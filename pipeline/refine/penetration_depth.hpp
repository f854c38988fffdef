#pragma once
#include <span>
#include <vector>

#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Measures how far two bodies with triangles reach into each other: World::penetration(). One thread's working memory;
/// others may walk the same trees.
class PenetrationDepth {
public:
    /// The trees of both models must be there.
    /// @param contacts  all of the pair
    /// Cost: a look at each triangle of both; a point placed for each piece into which the contacts cut a mesh, and
    /// some dozens of distances of points.
    Penetration measure(const PairTask& task, std::span<const Contact> contacts);

private:
    /// One body as its vertices are looked for in the other, in the frame of body a.
    struct Side {
        Model* model;
        RelativePose to_a;
    };
    void find_inside(const Side& inner, const Side& outer, std::span<const std::uint8_t> meets);
    std::uint32_t root_of(std::uint32_t vertex);
    void find_deepest(const Side& outer, bool of_a, Penetration& found);
    Distance to_surface(const Side& outer, const Eigen::Vector3d& point);

    PointLocator locator_;
    Traversal walk_;
    std::vector<std::uint8_t> meets_;
    std::vector<std::uint32_t> roots_, inside_; ///< inside_: vertices of one mesh
    std::vector<Eigen::Vector3d> points_;       ///< of these, in the frame of body a
    std::vector<Eigen::Vector3d> all_;          ///< whose hull holds what both bodies have in common, in the world
};

} // namespace oncollide
