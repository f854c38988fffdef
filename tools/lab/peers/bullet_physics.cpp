// Bodies that Bullet moves.
#include "peers/bullet_shapes.hpp"

#include <chrono>

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include "common/statistics.hpp"

namespace oncollide::tools {

using namespace bullet;

namespace {

/// Measures its detection.
class TimedWorld final : public btDiscreteDynamicsWorld {
public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
    void performDiscreteCollisionDetection() override
    {
        const Clock::time_point from = Clock::now();
        btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
        detection_ms += milliseconds_since(from);
    }
    double detection_ms = 0;
};

class BulletPhysicsPeer final : public PhysicsPeer {
public:
    BulletPhysicsPeer(std::span<const PhysicsBody> bodies, const PhysicsSettings& settings) : dt_(settings.dt)
    {
        world_.setGravity({0, 0, btScalar(-9.81)});
        for (const PhysicsBody& of : bodies) {
            const BulletShapes::Shape shape = shapes_.of(*of.geometry, of.mass == 0);
            btRigidBody::btRigidBodyConstructionInfo info(btScalar(of.mass), nullptr, shape.shape,
                                                          vector_of(of.inertia));
            info.m_friction = btScalar(std::sqrt(settings.friction)); // a pair's is the product of both
            info.m_linearDamping = btScalar(settings.damping), info.m_angularDamping = btScalar(settings.spin_damping);
            info.m_startWorldTransform = transform_of(of.pose * Eigen::Translation3d(shape.origin));
            world_.addRigidBody(bodies_.emplace_back(std::make_unique<btRigidBody>(info)).get());
        }
    }
    ~BulletPhysicsPeer() override
    {
        for (const auto& body : bodies_) world_.removeRigidBody(body.get());
    }
    PhysicsStep step() override
    {
        world_.detection_ms = 0;
        const Clock::time_point from = Clock::now();
        world_.stepSimulation(btScalar(dt_), 0); // one step of this length
        PhysicsStep done;
        done.detection_ms = world_.detection_ms, done.solver_ms = milliseconds_since(from) - world_.detection_ms;
        for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
            done.contacts += static_cast<std::size_t>(dispatcher_.getManifoldByIndexInternal(i)->getNumContacts());
        for (const auto& body : bodies_) {
            if (body->isStaticObject() || !body->isActive()) continue;
            ++done.awake, done.fastest = std::max(done.fastest, double(body->getLinearVelocity().length()));
        }
        return done;
    }
    void poses(std::vector<Eigen::Isometry3d>& poses) const override
    {
        poses.clear();
        for (const auto& body : bodies_) {
            const btTransform& at = body->getWorldTransform();
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            for (int row = 0; row < 3; ++row)
                for (int column = 0; column < 3; ++column) pose.linear()(row, column) = at.getBasis()[row][column];
            const btVector3& p = at.getOrigin();
            pose.translation() = Eigen::Vector3d(p.x(), p.y(), p.z());
            poses.push_back(pose);
        }
    }

private:
    double dt_;
    BulletShapes shapes_{true};
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broad_;
    btSequentialImpulseConstraintSolver solver_;
    TimedWorld world_{&dispatcher_, &broad_, &solver_, &configuration_};
    std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

} // namespace

void add_bullet_physics(Contenders& all)
{
    all.physics.all.push_back({.name = "bullet",
                               .what = "Bullet btDiscreteDynamicsWorld, concave meshes as their hulls",
                               .promise = Promise::approximate,
                               .make = maker<BulletPhysicsPeer>()});
}

} // namespace oncollide::tools
