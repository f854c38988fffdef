// ObbTree: meshes whose vertices move.
#include <oncollide/narrowphase/obb/obb_tree_deform.hpp>

#include <cmath>

#include <oncollide/narrowphase/obb/fits/box_fit.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {

void ObbTree::deform(std::uint32_t first, std::uint32_t count, double radius2)
{
    ONCOLLIDE_ASSERT(!chunked_);
    if (!deformation_) deformation_ = std::make_unique<Deformation>(*this), checks_ = true;
    deformation_->move(first, count, radius2);
}

std::uint64_t ObbTree::boxes_refitted() const
{
    return deformation_ ? deformation_->boxes_refitted() : 0;
}

void ObbTree::make_current(Node index) const
{
    if (chunked_)
        chunked_->opened(index);
    else
        deformation_->make_current(index);
}

void ObbTree::Deformation::move(std::uint32_t first, std::uint32_t count, double radius2)
{
    const std::size_t before = bytes();
    if (is_scattered()) divide_anew();
    ++version_;
    clusters_late_ = true;
    clusters_.move(first, count, version_);
    // Boxes are relative to the centre. A new tree would have the same centre and radius, so rounding is the same.
    const Eigen::Vector3d centre = tree_.bounds().centre();
    const bool all = count == tree_.mesh_->vertices.size() || centre != tree_.centre_;
    if (all || clusters_.empty()) all_moved_at_ = version_;
    tree_.centre_ = centre, tree_.radius_ = radius_from(radius2);
    tree_.make_root(tree_.mesh_->triangles.size());
    node_at(tree_.blocks_, root).fitted = version_;
    tree_.count(0, bytes() - before);
}

void ObbTree::Deformation::make_current(Node index)
{
    BoxNode& node = node_at(tree_.blocks_, index);
    const std::atomic_ref fitted(node.fitted);
    if (fitted.load(std::memory_order_acquire) == version_) return;
    const std::lock_guard lock(tree_.growing_);
    if (fitted.load(std::memory_order_relaxed) == version_) return; // another traversal fitted it first
    const Range range = range_of(index);
    if (clusters_late_ && range.count > most_to_triangles) bring_up_clusters();
    if (moved(index, range)) {
        range.count > most_to_triangles ? fit_to_clusters(node, range) : fit_to_triangles(node, range);
        refitted_ += node.lanes;
    }
    fitted.store(version_, std::memory_order_release);
}

ObbTree::Deformation::Range ObbTree::Deformation::range_of(Node index) const
{
    Range range{.begin = tree_.begin_of(index, 0)};
    for (unsigned k = 0; k < tree_.node(index).lanes; ++k) range.count += range.counts[k] = tree_.count_of(index, k);
    return range;
}

bool ObbTree::Deformation::fits(Node index) const
{
    return is_current(index) || !moved(index, range_of(index));
}

bool ObbTree::Deformation::moved(Node index, const Range& range) const
{
    const std::uint32_t fitted = tree_.node(index).fitted;
    return fitted == never || fitted < all_moved_at_ || clusters_.moved_since(fitted, range.begin, range.count);
}

void ObbTree::Deformation::fit_to_triangles(BoxNode& node, const Range& range) const
{
    const auto corners_at = [&](std::uint32_t place) {
        TrianglePoints t = tree_.corners(tree_.order_[place]);
        for (Eigen::Vector3d& p : t) p -= tree_.centre_;
        return t;
    };
    Aabb around;
    for (std::uint32_t place = range.begin; place < range.begin + range.count; ++place)
        for (const Eigen::Vector3d& p : corners_at(place)) around.add(p);
    set_frame(node, around.centre(), around.half_extent().norm());
    std::array<std::uint32_t, most_lanes> first{range.begin};
    for (unsigned k = 1; k < most_lanes; ++k) first[k] = first[k - 1] + range.counts[k - 1];
    static thread_local BoxFit fit;
    set_boxes(node, fit.fit(range.counts, frame_of(node),
                            [&](unsigned k, std::uint32_t i) { return corners_at(first[k] + i); }));
}

void ObbTree::Deformation::fit_to_clusters(BoxNode& node, const Range& range) const
{
    std::array<Aabb, most_lanes> boxes;
    Aabb around;
    std::uint32_t begin = range.begin;
    for (unsigned k = 0; k < node.lanes; begin += range.counts[k++]) {
        boxes[k] = clusters_.bounds(begin, range.counts[k]);
        boxes[k].min -= tree_.centre_, boxes[k].max -= tree_.centre_;
        around.add(boxes[k]);
    }
    set_frame(node, around.centre(), around.half_extent().norm());
    for (unsigned k = 0; k < node.lanes; ++k) set_box(node, k, boxes[k]);
}

/// Brings the clusters' AABBs up to date. The first time it makes the clusters, and grows the tree down to them.
void ObbTree::Deformation::bring_up_clusters()
{
    const bool made = !clusters_.empty();
    if (!made) {
        const std::size_t before = bytes();
        add_clusters(root);
        clusters_.end();
        tree_.count(0, bytes() - before);
        all_moved_at_ = version_; // the clusters know of no earlier version
    }
    clusters_.update(*tree_.mesh_);
    clusters_late_ = false;
    const double area = area_of(tree_.bounds());
    scatter_ = area > 0 ? clusters_.area() / area : 0;
    if (!made) scatter_when_divided_ = divided_anew_ ? scatter_ : 0;
}

void ObbTree::Deformation::add_clusters(Node index)
{
    for (unsigned k = 0; k < tree_.node(index).lanes; ++k) {
        const std::uint32_t begin = tree_.begin_of(index, k), count = tree_.count_of(index, k);
        if (count <= MeshClusters::most) {
            clusters_.add(*tree_.mesh_, begin, {tree_.order_ + begin, count});
            continue;
        }
        add_clusters(tree_.is_grown(index, k) ? tree_.grown(index, k) : tree_.grow_locked(index, k));
    }
}

/// True if the tree's division is of no use any more. A point of a solid ball of triangles is in about as many clusters
/// as the cube root of their number, and that is the worst that a new division leads to.
bool ObbTree::Deformation::is_scattered() const
{
    return scatter_ > std::max(2 * std::cbrt(double(clusters_.size())), 2 * scatter_when_divided_);
}

void ObbTree::Deformation::divide_anew()
{
    clusters_.clear(), scatter_ = 0;
    divided_anew_ = true;
    tree_.drop_table(), tree_.make_table();
}

} // namespace oncollide
