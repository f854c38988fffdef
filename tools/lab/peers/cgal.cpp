// CGAL's trees and its box intersection are under the GPL: they serve only this comparison, and the installed libraries
// do not contain them.
#include "peers/peers.hpp"

#include <iterator>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

namespace oncollide::tools {
namespace {

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

/// Streamed segment trees, rebuilt each frame.
class CgalBroadPeer final : public BroadPeer {
public:
    void start(const BoxFrame&) override {}

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        movers_.clear(), statics_.clear(), pairs.clear();
        for (std::uint32_t i = 0; i < frame.boxes.size(); ++i) {
            Aabb box = frame.boxes[i];
            (frame.is_static[i] ? statics_ : movers_).emplace_back(box.min.data(), box.max.data(), i);
        }
        const auto take = [&](const Box& a, const Box& b) { pairs.push_back({a.info(), b.info()}); };
        CGAL::box_self_intersection_d(movers_.begin(), movers_.end(), take);
        if (!statics_.empty())
            CGAL::box_intersection_d(movers_.begin(), movers_.end(), statics_.begin(), statics_.end(), take);
    }

private:
    std::vector<Box> movers_, statics_; ///< CGAL reorders them
};

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

/// A tree over the first mesh, searched for each triangle of the second at its pose. Exact for vertices rounded to
/// double. CGAL does not support triangles without area, so they are left out.
class CgalNarrowPeer final : public NarrowPeer {
public:
    CgalNarrowPeer(const Mesh& a, const Mesh& b) : b_(b), moved_(b.vertices.size())
    {
        for (std::uint32_t i = 0; i < a.triangles.size(); ++i)
            if (const Kernel::Triangle_3 t = triangle(a.triangles[i], a.vertices); !t.is_degenerate())
                triangles_.push_back(t), numbers_.push_back(i);
        tree_.rebuild(triangles_.cbegin(), triangles_.cend());
        tree_.build();
    }

    bool collides(const Eigen::Isometry3d& b) override
    {
        move(b);
        for (const Triangle& corners : b_.triangles)
            if (const Kernel::Triangle_3 t = triangle(corners, moved_); !t.is_degenerate() && tree_.do_intersect(t))
                return true;
        return false;
    }

    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        move(b), pairs.clear();
        for (std::uint32_t j = 0; j < b_.triangles.size(); ++j) {
            const Kernel::Triangle_3 t = triangle(b_.triangles[j], moved_);
            if (t.is_degenerate()) continue;
            found_.clear();
            tree_.all_intersected_primitives(t, std::back_inserter(found_));
            for (const Iterator& i : found_) pairs.push_back({numbers_[std::size_t(i - triangles_.cbegin())], j});
        }
    }

private:
    static Kernel::Triangle_3 triangle(const Triangle& corners, const std::vector<Eigen::Vector3d>& vertices)
    {
        const auto point = [&](std::uint32_t v) {
            return Kernel::Point_3(vertices[v].x(), vertices[v].y(), vertices[v].z());
        };
        return {point(corners[0]), point(corners[1]), point(corners[2])};
    }

    void move(const Eigen::Isometry3d& b)
    {
        for (std::size_t v = 0; v < moved_.size(); ++v) moved_[v] = b * b_.vertices[v];
    }

    const Mesh& b_;
    std::vector<Eigen::Vector3d> moved_; ///< the second mesh's vertices
    std::vector<Kernel::Triangle_3> triangles_;
    std::vector<std::uint32_t> numbers_; ///< of triangles_ in the first mesh
    Tree tree_;
    std::vector<Iterator> found_;
};

} // namespace

void add_cgal(Contenders& all)
{
    all.broad.all.push_back({.name = "cgal", .what = "CGAL box_self_intersection_d", .make = [](int) {
                                 return std::make_unique<CgalBroadPeer>();
                             }});
    all.narrow.all.push_back({.name = "cgal",
                              .what = "CGAL AABB_tree of A, searched for each triangle of B; exact predicates",
                              .has_all_pairs = true,
                              .make = maker<CgalNarrowPeer>()});
    add_cgal_self(all);
}

} // namespace oncollide::tools
