#pragma once
#include <algorithm>
#include <vector>

#include <oncollide/robots/edges/edge_cull.hpp>
#include <oncollide/robots/edges/joint_cells.hpp>

namespace oncollide {

/// Lists the pairs that may meet on an edge, each with its first windows. Bounding spheres and solids rule out the
/// other pairs. Rigid parts are ruled out together, then one by one.
class EdgeSearch {
public:
    /// @param own  sorted slots of the bodies that are not tested
    EdgeSearch(const Robot::Impl& robot, const World& world, const RobotCheck& what, const Clearances& clearances,
               EdgeMotion& motion, EdgeCull& cull, const std::vector<std::uint32_t>& own);

    /// Adds to `items`.
    void run(std::vector<EdgeItem>& items);

private:
    void search_self(std::vector<EdgeItem>& items);
    void search_pair(const EdgeItem& whole, std::vector<EdgeItem>& items);
    /// Adds the first windows of two sides, the smaller of which has this radius.
    void add_windows(const EdgeItem& whole, const EdgeWays& ways, double radius, std::vector<EdgeItem>& items) const;
    void search_environment(std::vector<EdgeItem>& items);
    Aabb place_balls(std::uint32_t rigid);

    const Robot::Impl& robot_;
    const World& world_;
    const RobotCheck& what_;
    const Clearances& clearances_;
    EdgeMotion& motion_;
    EdgeCull& cull_;
    const std::shared_ptr<JointCells> cells_;
    JointCells::Scratch scratch_;
    const std::vector<std::uint32_t>& own_;
    std::vector<std::vector<std::uint32_t>> bundles_; ///< pairs of parts, by pairs of rigid parts
    std::vector<EdgeItem> coarse_;                    ///< items of rigid parts
    /// A ball around rigid parts in a window, with the clearance.
    struct Window {
        Eigen::Vector3d centre;
        double radius, bent; ///< bent: how far points leave the straight lines between their places at both ends
    };
    std::uint32_t windows_ = 1;
    std::vector<Window> balls_; ///< by rigid parts, then by windows
    std::vector<Aabb> queries_;
};

} // namespace oncollide
