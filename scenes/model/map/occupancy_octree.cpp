// Conversion of OctoMap's octrees to maps and back, and scans.
#include <cmath>

#include <octomap/OcTree.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/map/map_change.hpp>

namespace oncollide {

namespace {

/// Reads only leaves: inner nodes may be out of date.
class Reader {
public:
    explicit Reader(const octomap::OcTree& tree, bool unknown_is_occupied) : tree_(tree), cells_(unknown_is_occupied) {}

    CellTree read()
    {
        const octomap::OcTreeNode& root = *tree_.getRoot();
        if (tree_.nodeHasChildren(&root))
            cells_.set_grid(node(root));
        else
            cells_.set_grid(state(root));
        return std::move(cells_);
    }

private:
    CellState state(const octomap::OcTreeNode& leaf) const
    {
        if (!std::isfinite(leaf.getLogOdds())) throw Error(ErrorKind::bad_data, "octree: an occupancy is not finite");
        return tree_.isNodeOccupied(leaf) ? CellState::occupied : CellState::free;
    }
    CellTree::Node node(const octomap::OcTreeNode& from)
    {
        CellTree::Octants octants;
        for (unsigned k = 0; k < 8; ++k) {
            if (!tree_.nodeChildExists(&from, k)) continue;
            const octomap::OcTreeNode& child = *tree_.getNodeChild(&from, k);
            if (tree_.nodeHasChildren(&child))
                octants.set(k, node(child));
            else
                octants.set(k, state(child));
        }
        return cells_.close(octants);
    }

    const octomap::OcTree& tree_;
    CellTree cells_;
};

/// Removes the descendants of a node. OctoMap's own functions do so only if eight children are equal, and abort when a
/// node with children is removed.
void make_leaf(octomap::OcTree& tree, octomap::OcTreeNode* node)
{
    for (unsigned k = 0; k < 8; ++k) {
        if (!tree.nodeChildExists(node, k))
            tree.createNodeChild(node, k);
        else if (tree.nodeHasChildren(tree.getNodeChild(node, k)))
            make_leaf(tree, tree.getNodeChild(node, k));
        tree.getNodeChild(node, k)->setLogOdds(0);
    }
    tree.pruneNode(node);
}

void take_child(octomap::OcTree& tree, octomap::OcTreeNode* node, unsigned k)
{
    octomap::OcTreeNode* child = tree.getNodeChild(node, k);
    if (tree.nodeHasChildren(child)) make_leaf(tree, child);
    tree.deleteNodeChild(node, k);
}

float value_of(const octomap::OcTree& tree, CellState state)
{
    return state == CellState::free ? tree.getClampingThresMinLog() : tree.getClampingThresMaxLog();
}

/// Sets the cells of a box to one state; `node` is the node of the cube and not a leaf.
void set_cells(octomap::OcTree& tree, octomap::OcTreeNode* node, const MapCell& cube, const CellBox& box,
               CellState state)
{
    for (unsigned k = 0; k < 8; ++k) {
        const MapCell octant = cube.octant(k);
        if (!box.overlaps(CellBox(octant))) continue;
        const bool there = tree.nodeChildExists(node, k);
        const bool whole = box.contains(CellBox(octant));
        if (state == CellState::unknown && (whole || !there)) {
            if (there) take_child(tree, node, k);
            continue;
        }
        octomap::OcTreeNode* child = there ? tree.getNodeChild(node, k) : tree.createNodeChild(node, k);
        if (whole) {
            if (tree.nodeHasChildren(child)) make_leaf(tree, child);
            child->setLogOdds(value_of(tree, state));
            continue;
        }
        if (there && !tree.nodeHasChildren(child)) tree.expandNode(child);
        set_cells(tree, child, octant, box, state);
        if (!tree.nodeHasChildren(child))
            make_leaf(tree, child), tree.deleteNodeChild(node, k);
        else if (!tree.pruneNode(child))
            child->updateOccupancyChildren();
    }
}

class Writer {
public:
    explicit Writer(const OccupancyMap& map)
        : cells_(MapAccess::cells(map)), tree_(std::make_shared<octomap::OcTree>(map.resolution()))
    {
    }

    std::shared_ptr<octomap::OcTree> write()
    {
        tree_->setNodeValue(octomap::OcTreeKey(0, 0, 0), 0, true); // the root exists only after a cell exists
        octomap::OcTreeNode* root = tree_->getRoot();
        const CellTree::Node& top = cells_.top();
        if (top.inner & 1) {
            take_child(*tree_, root, 0);
            fill(root, cells_.below(top, 0));
        } else {
            make_leaf(*tree_, root);
            root->setLogOdds(value_of(*tree_, CellTree::state(top, 0)));
        }
        tree_->updateInnerOccupancy();
        return std::move(tree_);
    }

private:
    void fill(octomap::OcTreeNode* to, const CellTree::Node& from)
    {
        const unsigned whole = cells_.whole(from);
        for (unsigned k = 0; k < 8; ++k) {
            const bool inner = from.inner >> k & 1;
            if (!inner && !((whole | from.free) >> k & 1)) continue;
            octomap::OcTreeNode* child = tree_->createNodeChild(to, k);
            if (inner)
                fill(child, cells_.below(from, k));
            else
                child->setLogOdds(value_of(*tree_, whole >> k & 1 ? CellState::occupied : CellState::free));
        }
    }

    const CellTree& cells_;
    std::shared_ptr<octomap::OcTree> tree_;
};

octomap::point3d point_of(const Eigen::Vector3d& p)
{
    return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

} // namespace

OccupancyMap make_occupancy_map(const octomap::OcTree& tree, bool unknown_is_occupied)
{
    check_resolution("octree", tree.getResolution());
    if (tree.size() == 0) throw Error(ErrorKind::bad_data, "octree: the map is empty");
    return MapAccess::make("octree", Reader(tree, unknown_is_occupied).read(), tree.getResolution());
}

OccupancyMap make_occupancy_map(std::shared_ptr<const octomap::OcTree> tree, bool unknown_is_occupied)
{
    if (!tree) throw Error(ErrorKind::bad_data, "octree: there is none");
    OccupancyMap map = make_occupancy_map(*tree, unknown_is_occupied);
    map.keep(std::move(tree));
    return map;
}

std::shared_ptr<octomap::OcTree> make_octree(const OccupancyMap& map)
{
    return Writer(map).write();
}

void OccupancyMap::insert_scan(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin, double max_range)
{
    cell_at(*this, origin);
    octomap::Pointcloud scan;
    for (const Eigen::Vector3d& point : points) cell_at(*this, point), scan.push_back(point_of(point));

    auto& [cells, bounds, given, scanned, since_scan] = *data_;
    if (!scanned || scanned.use_count() > 1) // a copy of the map shares it
        scanned = scanned ? std::make_shared<octomap::OcTree>(*scanned)
                  : given ? std::make_shared<octomap::OcTree>(*given)
                          : make_octree(*this);
    given.reset();
    for (const auto& [box, state] : since_scan) {
        octomap::OcTreeNode* root = scanned->getRoot();
        if (!scanned->nodeHasChildren(root)) scanned->expandNode(root);
        set_cells(*scanned, root, CellTree::top_cube.octant(0), box, state);
    }
    since_scan.clear();

    scanned->enableChangeDetection(true);
    scanned->resetChangeDetection();
    scanned->insertPointCloud(scan, point_of(origin), max_range);
    MapChange change(*this, true);
    for (auto changed = scanned->changedKeysBegin(); changed != scanned->changedKeysEnd(); ++changed) {
        const octomap::OcTreeKey& key = changed->first;
        const octomap::OcTreeNode* node = scanned->search(key);
        const Eigen::Vector3i cell = Eigen::Vector3i(key[0], key[1], key[2]).array() + CellTree::lowest;
        change.set({cell, cell.array() + 1}, !node                           ? CellState::unknown
                                             : scanned->isNodeOccupied(node) ? CellState::occupied
                                                                             : CellState::free);
    }
    try {
        change.commit();
    } catch (const Error&) {
        scanned.reset(); // the new octree matches the map as it is now
        throw;
    }
}

} // namespace oncollide
