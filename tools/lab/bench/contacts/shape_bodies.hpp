// Bodies that are shapes, where they touch others: for the scenes of 'bench contacts'. Equal arguments give equal
// bodies; only distances and verdicts of the library take part, and no contacts.
#pragma once
#include <map>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>
#include <oncollide/samples/varied_shapes.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide::tools {

/// How far b can move along the unit vector `way` until it touches a; infinite if it passes, 0 if they meet already.
/// Convex solids do not meet before b reaches the plane between them, which is found anew from there.
double way_until_touching(const Convex& a, const Eigen::Isometry3d& at_a, const Convex& b, Eigen::Isometry3d at_b,
                          const Eigen::Vector3d& way);

/// Bodies on a floor (z = 0) in a square around the origin, one by one: each comes from above and goes, without
/// rotation, to the deepest place that it can reach downhill, where it rests on about three others; then it sinks in.
class ShapeHeap {
public:
    ShapeHeap(double side, double sink) : half_(side / 2), sink_(sink) {}
    /// Starts at this place of the square, -1 to 1. The model must outlive the heap.
    Eigen::Isometry3d add(Model& model, const Eigen::Quaterniond& rotation, double x, double y);

private:
    struct Placed {
        Model* model;
        Eigen::Isometry3d pose;
    };
    struct Above {
        double most; ///< no higher place of the new body touches it
        const Placed* placed;
    };
    using Cell = std::pair<int, int>;
    static Cell cell_of(double x, double y);
    /// The height of the body's origin at which it comes to lie at `pose`; `limit` if it is not below.
    double lowest(Model& model, Eigen::Isometry3d pose, double limit);

    double half_, sink_;
    double largest_ = 0; ///< reach of all bodies so far
    std::map<Cell, std::vector<Placed>> cells_;
    std::vector<Above> above_;
};

/// Where a shape that comes from above lies on a terrain, sunk in by this depth: its z axis along the terrain's normal,
/// or, on its side, across it.
Eigen::Isometry3d lie_on(const Terrain& terrain, Model& model, const Eigen::Vector2d& at, double yaw, bool on_its_side,
                         double sink);

} // namespace oncollide::tools
