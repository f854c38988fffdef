// A small solver of rigid contacts by sequential impulses on the manifolds of a World: an example, and the instrument
// of tests. Impulses are kept over frames by ManifoldTracker. Source: Catto, "Iterative dynamics with temporal
// coherence", GDC 2005; the second pass without bias as in Box2D 3.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <oncollide/pipeline/manifold_tracker.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide::example {

/// A body of the solver. The centre of mass is the origin of its frame, and its inertia is diagonal there.
struct RigidBody {
    BodyId id;
    double inverse_mass = 0; ///< 1/kg; 0: it does not move
    Eigen::Vector3d inverse_inertia = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), spin = Eigen::Vector3d::Zero(); ///< m/s, rad/s
};

class ImpulseSolver {
public:
    double dt = 1e-3, friction = 0.5, margin = 1e-3, slop = 1e-4;
    Eigen::Vector3d gravity{0, 0, -9.81};
    int iterations = 20, relaxations = 20;
    std::vector<RigidBody> bodies; ///< in the order of the World's slots

    explicit ImpulseSolver(World& world) : world_(world) {}
    void step() { detect(), advance(); }
    /// Finds the contacts of the bodies as they are.
    void detect()
    {
        world_.step();
        manifolds_ = &world_.manifolds({.margin = margin});
    }
    /// Moves the bodies by dt, against these contacts.
    void advance()
    {
        add_rows();
        for (RigidBody& body : bodies)
            if (body.inverse_mass > 0) body.velocity += dt * gravity;
        for (const Row& row : rows_)
            for (const Axis& axis : row.axes) apply(row, axis, axis.impulse);
        for (int i = 0; i < iterations; ++i) solve(true);
        for (const RigidBody& body : bodies)
            if (body.inverse_mass > 0) move(body);
        for (int i = 0; i < relaxations; ++i) solve(false);
        impulses_.clear();
        for (const auto& [a, b, axes, depth] : rows_)
            impulses_.push_back({axes[0].impulse, axes[1].impulse, axes[2].impulse});
    }
    /// The contacts that the last detect() found; step() moves the bodies after it.
    const FrameManifolds& manifolds() const { return *manifolds_; }
    std::size_t contacts() const { return rows_.size(); }
    double deepest() const ///< metres
    {
        double most = 0;
        for (const Row& row : rows_) most = std::max(most, row.depth);
        return most;
    }

private:
    /// One direction of a contact, and the changes by an impulse along it.
    struct Axis {
        Eigen::Vector3d along, turn_a, turn_b, spin_a, spin_b; ///< turn: torque of a unit impulse; spin: its change
        double mass, impulse;
    };
    struct Row {
        RigidBody *a, *b;
        std::array<Axis, 3> axes; ///< the normal and two tangents
        double depth;
    };

    void add_rows()
    {
        const FrameManifolds& found = *manifolds_;
        const ManifoldTracker::Update& update = tracker_.update(world_, found.pairs, found);
        std::vector<Eigen::Vector3d> kept(found.points.size(), Eigen::Vector3d::Zero());
        for (std::size_t i = 0; i < kept.size(); ++i)
            if (update.previous[i] != ManifoldTracker::none) kept[i] = impulse_of(update.previous[i]);
        rows_.clear(), row_of_.assign(found.points.size(), ManifoldTracker::none);
        for (std::size_t i = 0; i < found.pairs.size(); ++i) {
            const PairOfBodies& pair = found.pairs[i];
            if (bodies[pair.a.slot].inverse_mass + bodies[pair.b.slot].inverse_mass == 0) continue;
            for (std::size_t k = found.offsets[i]; k < found.offsets[i + 1]; ++k) {
                const ManifoldRegion& region = found.regions[k];
                if (region.normal_error > 1) continue; // no normal has a meaning there
                for (std::uint32_t p = region.first; p < region.first + region.count; ++p) {
                    row_of_[p] = static_cast<std::uint32_t>(rows_.size());
                    add(pair, found.points[p], kept[p]);
                }
            }
        }
        std::swap(last_row_of_, row_of_);
    }
    Eigen::Vector3d impulse_of(std::uint32_t point) const
    {
        const std::uint32_t row = last_row_of_[point];
        return row == ManifoldTracker::none ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : impulses_[row];
    }
    void add(const PairOfBodies& pair, const ManifoldPoint& point, const Eigen::Vector3d& impulse)
    {
        Row row{&bodies[pair.a.slot], &bodies[pair.b.slot], {}, point.depth};
        const Eigen::Isometry3d &at_a = world_.bodies().pose(pair.a), &at_b = world_.bodies().pose(pair.b);
        const Eigen::Vector3d at = 0.5 * (point.point_a + point.point_b);
        const Eigen::Vector3d arm_a = at - at_a.translation(), arm_b = at - at_b.translation();
        Eigen::Index least = 0;
        point.normal.cwiseAbs().minCoeff(&least);
        row.axes[0].along = point.normal;
        row.axes[1].along = point.normal.cross(Eigen::Vector3d::Unit(least)).normalized();
        row.axes[2].along = point.normal.cross(row.axes[1].along);
        for (const int k : {0, 1, 2}) {
            Axis& axis = row.axes[static_cast<std::size_t>(k)];
            const auto spin = [](const RigidBody& body, const Eigen::Isometry3d& pose,
                                 const Eigen::Vector3d& turn) -> Eigen::Vector3d {
                return pose.linear() * body.inverse_inertia.cwiseProduct(pose.linear().transpose() * turn);
            };
            axis.turn_a = arm_a.cross(axis.along), axis.turn_b = arm_b.cross(axis.along);
            axis.spin_a = spin(*row.a, at_a, axis.turn_a), axis.spin_b = spin(*row.b, at_b, axis.turn_b);
            axis.mass = 1 / (row.a->inverse_mass + row.b->inverse_mass + axis.turn_a.dot(axis.spin_a) +
                             axis.turn_b.dot(axis.spin_b));
            axis.impulse = impulse[k];
        }
        rows_.push_back(row);
    }
    static void apply(const Row& row, const Axis& axis, double impulse)
    {
        row.a->velocity -= row.a->inverse_mass * impulse * axis.along, row.a->spin -= impulse * axis.spin_a;
        row.b->velocity += row.b->inverse_mass * impulse * axis.along, row.b->spin += impulse * axis.spin_b;
    }
    void solve(bool with_bias)
    {
        for (Row& row : rows_) {
            const auto speed = [&](const Axis& axis) { // of b away from a
                return axis.along.dot(row.b->velocity - row.a->velocity) + axis.turn_b.dot(row.b->spin) -
                       axis.turn_a.dot(row.a->spin);
            };
            const auto change = [&](Axis& axis, double to) {
                apply(row, axis, to - axis.impulse);
                axis.impulse = to;
            };
            auto& [normal, along, across] = row.axes;
            for (Axis* axis : {&along, &across}) {
                const double most = friction * normal.impulse;
                change(*axis, std::clamp(axis->impulse - axis->mass * speed(*axis), -most, most));
            }
            // Points apart may close their gap in this step; deep ones part slowly.
            double wanted = row.depth < 0 ? row.depth / dt : 0;
            if (with_bias && row.depth > slop) wanted = std::min(0.1 * (row.depth - slop) / dt, 0.5);
            change(normal, std::max(normal.impulse + normal.mass * (wanted - speed(normal)), 0.0));
        }
    }
    void move(const RigidBody& body)
    {
        Eigen::Isometry3d pose = world_.bodies().pose(body.id);
        pose.translation() += dt * body.velocity;
        if (const double angle = dt * body.spin.norm(); angle > 0) {
            const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, body.spin.normalized()) * pose.linear());
            pose.linear() = turned.normalized().toRotationMatrix();
        }
        world_.bodies().set_pose(body.id, pose);
    }

    World& world_;
    ManifoldTracker tracker_{0.02};
    const FrameManifolds* manifolds_ = nullptr; ///< the World's, of the last step
    std::vector<Row> rows_;
    std::vector<std::uint32_t> row_of_, last_row_of_; ///< for each point
    std::vector<Eigen::Vector3d> impulses_;
};

/// The mass and inertia of a box of this density (kg/m^3), for a body that is one or is taken for one.
inline RigidBody box_body(BodyId id, const Eigen::Vector3d& half, double density = 1000)
{
    const double mass = 8 * half.prod() * density;
    const Eigen::Vector3d squares = half.cwiseProduct(half);
    const Eigen::Vector3d inertia =
        mass / 3 * Eigen::Vector3d(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
    return {.id = id, .inverse_mass = 1 / mass, .inverse_inertia = inertia.cwiseInverse()};
}

} // namespace oncollide::example
