// A small solver of rigid contacts by sequential impulses on the manifolds of a World: an example, and the instrument
// of tests. Impulses are kept over frames by ManifoldTracker. Source: Catto, "Iterative dynamics with temporal
// coherence", GDC 2005; the second pass without bias as in Box2D 3.
#pragma once
#include <algorithm>
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
        for (Row& row : rows_) apply(row, row.impulse);
        for (int i = 0; i < iterations; ++i) solve(true);
        for (const RigidBody& body : bodies)
            if (body.inverse_mass > 0) move(body);
        for (int i = 0; i < relaxations; ++i) solve(false);
        impulses_.clear();
        for (const Row& row : rows_) impulses_.push_back(row.impulse);
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
    struct Row {
        RigidBody *a, *b;
        Eigen::Vector3d arm_a, arm_b, normal, along[2];
        double depth, mass, mass_along[2];
        Eigen::Vector3d impulse; ///< along the normal and both tangents
    };

    void add_rows()
    {
        const FrameManifolds& found = *manifolds_;
        const ManifoldTracker::Update& update = tracker_.update(world_, found.pairs, found);
        std::vector<Eigen::Vector3d> kept(found.points.size(), Eigen::Vector3d::Zero());
        for (std::size_t i = 0; i < kept.size(); ++i)
            if (update.previous[i] != ManifoldTracker::none) kept[i] = impulse_of(update.previous[i]);
        rows_.clear(), row_of_.assign(found.points.size(), ManifoldTracker::none);
        for (std::size_t i = 0; i < found.pairs.size(); ++i)
            for (std::size_t k = found.offsets[i]; k < found.offsets[i + 1]; ++k) {
                const ManifoldRegion& region = found.regions[k];
                if (region.normal_error > 1) continue; // no normal has a meaning there
                for (std::uint32_t p = region.first; p < region.first + region.count; ++p) {
                    row_of_[p] = static_cast<std::uint32_t>(rows_.size());
                    add(found.pairs[i], found.points[p], kept[p]);
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
        Row row{&bodies[pair.a.slot], &bodies[pair.b.slot], {}, {}, point.normal, {}, point.depth, 0, {}, impulse};
        const Eigen::Vector3d at = 0.5 * (point.point_a + point.point_b);
        row.arm_a = at - world_.bodies().pose(pair.a).translation(),
        row.arm_b = at - world_.bodies().pose(pair.b).translation();
        Eigen::Index axis = 0;
        point.normal.cwiseAbs().minCoeff(&axis);
        row.along[0] = point.normal.cross(Eigen::Vector3d::Unit(axis)).normalized();
        row.along[1] = point.normal.cross(row.along[0]);
        const auto mass_along = [&](const Eigen::Vector3d& d) {
            const Eigen::Vector3d turn_a = row.arm_a.cross(d), turn_b = row.arm_b.cross(d);
            return 1 / (row.a->inverse_mass + row.b->inverse_mass + turn_a.dot(inverse_inertia(*row.a, turn_a)) +
                        turn_b.dot(inverse_inertia(*row.b, turn_b)));
        };
        row.mass = mass_along(row.normal);
        for (const int k : {0, 1}) row.mass_along[k] = mass_along(row.along[k]);
        if (row.a->inverse_mass + row.b->inverse_mass > 0)
            rows_.push_back(row);
        else
            row_of_[static_cast<std::size_t>(&point - manifolds_->points.data())] = ManifoldTracker::none;
    }
    Eigen::Vector3d inverse_inertia(const RigidBody& body, const Eigen::Vector3d& torque) const
    {
        const Eigen::Matrix3d& turn = world_.bodies().pose(body.id).linear();
        return turn * body.inverse_inertia.cwiseProduct(turn.transpose() * torque);
    }
    void apply(const Row& row, const Eigen::Vector3d& impulse)
    {
        const Eigen::Vector3d p = impulse[0] * row.normal + impulse[1] * row.along[0] + impulse[2] * row.along[1];
        row.a->velocity -= row.a->inverse_mass * p, row.a->spin -= inverse_inertia(*row.a, row.arm_a.cross(p));
        row.b->velocity += row.b->inverse_mass * p, row.b->spin += inverse_inertia(*row.b, row.arm_b.cross(p));
    }
    void solve(bool with_bias)
    {
        for (Row& row : rows_) {
            const auto speed = [&](const Eigen::Vector3d& d) { // of b away from a
                return d.dot(row.b->velocity + row.b->spin.cross(row.arm_b) - row.a->velocity -
                             row.a->spin.cross(row.arm_a));
            };
            const auto change = [&](int k, double to) {
                Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
                impulse[k] = to - row.impulse[k], row.impulse[k] = to;
                apply(row, impulse);
            };
            for (const int k : {0, 1}) {
                const double most = friction * row.impulse[0];
                change(k + 1, std::clamp(row.impulse[k + 1] - row.mass_along[k] * speed(row.along[k]), -most, most));
            }
            // Points apart may close their gap in this step; deep ones part slowly.
            double wanted = row.depth < 0 ? row.depth / dt : 0;
            if (with_bias && row.depth > slop) wanted = std::min(0.1 * (row.depth - slop) / dt, 0.5);
            change(0, std::max(row.impulse[0] + row.mass * (wanted - speed(row.normal)), 0.0));
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
