#pragma once
#include <span>
#include <vector>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/inside/point_location.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

/// Measures the penetration of two bodies with triangles: Pairs::penetration(). One thread's working memory; other
/// threads may traverse the same trees.
class PenetrationDepth {
public:
    /// The trees of both models must exist.
    /// @param contacts  all contacts of the pair
    /// @param locator, walk  working memory
    /// Cost: a scan of all triangles of both bodies; one point location for each piece into which the contacts cut a
    /// mesh; and some dozens of point distances.
    Penetration measure(const PairTask& task, std::span<const Contact> contacts, PointLocator& locator,
                        Traversal& walk);

private:
    /// One body, and the transformation into the frame of body a.
    struct Side {
        Model* model;
        RelativePose to_a;
    };
    void find_inside(const Side& inner, const Side& outer, std::span<const std::uint8_t> meets);
    std::uint32_t root_of(std::uint32_t vertex);
    void find_deepest(const Side& outer, bool of_a, Penetration& found);
    Distance to_surface(const Side& outer, const Eigen::Vector3d& point);

    PointLocator* locator_ = nullptr; ///< locator of the current call, like walk_
    Traversal* walk_ = nullptr;
    std::vector<std::uint8_t> meets_;
    std::vector<std::uint32_t> roots_, inside_; ///< inside_: vertices of one mesh
    std::vector<Eigen::Vector3d> points_;       ///< positions of inside_, in the frame of body a
    std::vector<Eigen::Vector3d> all_;          ///< points whose hull contains the bodies' intersection, world frame
};

} // namespace oncollide
