#pragma once
#include <algorithm>
#include <vector>

#include <oncollide/robots/edge_motion.hpp>

namespace oncollide {

/// Lists the pairs that may meet on an edge, each in the windows to begin with: bounding spheres and the World's boxes
/// rule out the others. Rigid parts are ruled out together, then one by one.
class EdgeSearch {
public:
    /// @param own  sorted slots of the bodies that are not tested
    EdgeSearch(const Robot::Impl& robot, const World& world, const RobotCheck& what, EdgeMotion& motion,
               const std::vector<std::uint32_t>& own);

    /// Adds to `items`. Returns the number of pairs that the World tested.
    std::size_t run(std::vector<EdgeItem>& items);

private:
    void search_self(std::vector<EdgeItem>& items);
    void search_pair(const EdgeItem& whole, std::vector<EdgeItem>& items);
    /// Adds the windows of two sides to begin with, the smaller of which has this radius.
    void add_windows(const EdgeItem& whole, const EdgeWays& ways, double radius, std::vector<EdgeItem>& items) const;
    void search_environment(std::vector<EdgeItem>& items);
    template <class Prepare, class Take>
    void query(std::vector<EdgeItem>& items, Prepare prepare, Take take);

    const Robot::Impl& robot_;
    const World& world_;
    const RobotCheck& what_;
    EdgeMotion& motion_;
    const std::vector<std::uint32_t>& own_;
    std::size_t tests_ = 0;
    std::vector<std::vector<std::uint32_t>> bundles_; ///< pairs of parts, by pairs of rigid parts
    std::vector<EdgeItem> coarse_, fine_, halves_;    ///< of rigid parts, of parts
    std::vector<ModelQuery> queries_;
    std::vector<double> reaches_;
    std::vector<std::uint8_t> is_coarse_;
    QueryHits hits_;
};

} // namespace oncollide
