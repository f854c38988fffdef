// Bullet's collision world and its tests of two convex shapes.
#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <btBulletCollisionCommon.h>

#include "bullet_shapes.hpp"

namespace {

using namespace league::bullet;

int supports(int question, int a, int b)
{
    const bool known = a >= 0 && a < LEAGUE_KIND_COUNT && b >= 0 && b < LEAGUE_KIND_COUNT;
    const bool planes = a == LEAGUE_HALF_SPACE && b == LEAGUE_HALF_SPACE;
    switch (question) {
    case LEAGUE_MEET:
    case LEAGUE_CONTACTS:
        return known && !planes;
    case LEAGUE_DISTANCE:
        return league::is_convex(a) && league::is_convex(b);
    case LEAGUE_DEPTH:
        return (league::is_convex(a) && (league::is_convex(b) || b == LEAGUE_HALF_SPACE)) ||
               (a == LEAGUE_HALF_SPACE && league::is_convex(b));
    case LEAGUE_CAST:
        return known && (league::is_convex(a) || league::is_convex(b));
    case LEAGUE_TURN:
        return known && league::is_convex(b);
    case LEAGUE_RAY:
        return a >= 0 && a < LEAGUE_KIND_COUNT;
    default:
        return question == LEAGUE_PAIRS;
    }
}

struct World {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad;
    btCollisionWorld world{&dispatcher, &broad, &configuration};

    World() { btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher); }
};

/// Finds the deepest contact of two bodies.
class Contact final : public league::Query {
public:
    explicit Contact(const league_case& asked)
        : a_(asked.a, false), b_(asked.b, false), depth_(asked.question == LEAGUE_DEPTH)
    {
        object_a_.setCollisionShape(a_.get()), object_a_.setWorldTransform(pose_of(asked.a));
        object_b_.setCollisionShape(b_.get()), object_b_.setWorldTransform(pose_of(asked.b));
    }

    int answer(const league_case&, league_answer& answer) override
    {
        Deepest deepest(&object_a_);
        world_.world.contactPairTest(&object_a_, &object_b_, deepest);
        answer.meet = deepest.distance <= 0;
        if (answer.meet && depth_) {
            answer.depth = double(-deepest.distance);
            copy(deepest.from_a, answer.normal);
        }
        return LEAGUE_ANSWERED;
    }

private:
    struct Deepest final : btCollisionWorld::ContactResultCallback {
        explicit Deepest(const btCollisionObject* object) : a(object) {}
        btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* first, int, int,
                                 const btCollisionObjectWrapper*, int, int) override
        {
            if (point.getDistance() < distance) {
                distance = point.getDistance();
                from_a = first->getCollisionObject() == a ? -point.m_normalWorldOnB : point.m_normalWorldOnB;
            }
            return 0;
        }
        const btCollisionObject* a;
        btScalar distance = BT_LARGE_FLOAT;
        btVector3 from_a{0, 0, 0};
    };

    Shape a_, b_;
    bool depth_;
    btCollisionObject object_a_, object_b_;
    World world_;
};

/// A step of a world of two bodies, and the contacts in its manifolds. A mesh that meets another or a plane needs
/// GImpact's form. It has no algorithms of closest points, which contactPairTest() queries for.
class Step final : public league::Query {
public:
    Step(const league_case& asked, bool deforming)
        : a_(asked.a, deforming), b_(asked.b, deforming), list_(asked.question == LEAGUE_CONTACTS)
    {
        if (list_) find_many();
        object_a_.setCollisionShape(a_.get()), object_a_.setWorldTransform(pose_of(asked.a));
        object_b_.setCollisionShape(b_.get()), object_b_.setWorldTransform(pose_of(asked.b));
        world_.world.addCollisionObject(&object_a_), world_.world.addCollisionObject(&object_b_);
    }
    ~Step() override { world_.world.removeCollisionObject(&object_a_), world_.world.removeCollisionObject(&object_b_); }

    int answer(const league_case&, league_answer& answer) override
    {
        // Each call is the first step: the manifolds of an earlier one go.
        if (list_)
            world_.broad.getOverlappingPairCache()->cleanProxyFromPairs(object_a_.getBroadphaseHandle(),
                                                                        &world_.dispatcher);
        world_.world.performDiscreteCollisionDetection();
        contacts_.clear();
        for (int i = 0; i < world_.dispatcher.getNumManifolds(); ++i) {
            const btPersistentManifold& manifold = *world_.dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold.getNumContacts(); ++k) {
                const btManifoldPoint& point = manifold.getContactPoint(k);
                if (point.getDistance() <= 0) answer.meet = 1;
                if (!list_) continue;
                league_contact& contact = contacts_.emplace_back();
                copy((point.getPositionWorldOnA() + point.getPositionWorldOnB()) / 2, contact.position);
                copy(manifold.getBody0() == &object_a_ ? -point.m_normalWorldOnB : point.m_normalWorldOnB,
                     contact.normal);
                contact.depth = double(-point.getDistance());
            }
        }
        answer.contacts = contacts_.data(), answer.contact_count = contacts_.size();
        return LEAGUE_ANSWERED;
    }

private:
    /// Several points from one step, and the normals of a mesh's faces at their inner edges: these are options.
    void find_many()
    {
        world_.configuration.setConvexConvexMultipointIterations();
        world_.configuration.setPlaneConvexMultipointIterations();
        a_.prepare_contacts(), b_.prepare_contacts();
        for (btCollisionObject* object : {&object_a_, &object_b_})
            object->setCollisionFlags(object->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
        gContactAddedCallback = [](btManifoldPoint& point, const btCollisionObjectWrapper* first, int part_of_first,
                                   int index_of_first, const btCollisionObjectWrapper* second, int part_of_second,
                                   int index_of_second) {
            // It does nothing if its first object is no triangle.
            btAdjustInternalEdgeContacts(point, first, second, part_of_first, index_of_first);
            btAdjustInternalEdgeContacts(point, second, first, part_of_second, index_of_second);
            return true;
        };
    }

    Shape a_, b_;
    bool list_;
    btCollisionObject object_a_, object_b_;
    World world_;
    std::vector<league_contact> contacts_;
};

/// Finds the nearest or the deepest points of two convex bodies.
class Points final : public league::Query {
public:
    explicit Points(const league_case& asked)
        : a_(asked.a, false), b_(asked.b, false), depth_(asked.question == LEAGUE_DEPTH)
    {
        input_.m_transformA = pose_of(asked.a), input_.m_transformB = pose_of(asked.b);
    }

    int answer(const league_case&, league_answer& answer) override
    {
        btVoronoiSimplexSolver simplex;
        btGjkEpaPenetrationDepthSolver epa;
        btGjkPairDetector detector(a_.convex(), b_.convex(), &simplex, &epa);
        btPointCollector found;
        detector.getClosestPoints(input_, found, nullptr);
        if (!found.m_hasResult) return LEAGUE_FAILED;
        answer.meet = found.m_distance <= 0;
        if (depth_) {
            if (!answer.meet) return LEAGUE_ANSWERED;
            answer.depth = double(-found.m_distance);
            copy(-found.m_normalOnBInWorld, answer.normal);
        } else if (!answer.meet) {
            answer.distance = double(found.m_distance);
            answer.has_points = 1;
            copy(found.m_pointInWorld + found.m_distance * found.m_normalOnBInWorld, answer.point_a);
            copy(found.m_pointInWorld, answer.point_b);
        }
        return LEAGUE_ANSWERED;
    }

private:
    Shape a_, b_;
    bool depth_;
    btDiscreteCollisionDetectorInterface::ClosestPointInput input_;
};

/// A world of one body, which a segment or a convex body meets.
class Target {
public:
    explicit Target(const league_body& body) : shape_(body, false)
    {
        object_.setCollisionShape(shape_.get()), object_.setWorldTransform(pose_of(body));
        space_.world.addCollisionObject(&object_);
    }
    ~Target() { space_.world.removeCollisionObject(&object_); }
    Target(const Target&) = delete;
    Target& operator=(const Target&) = delete;

    const btCollisionWorld& world() const { return space_.world; }

private:
    Shape shape_;
    btCollisionObject object_;
    World space_;
};

/// Moves a convex body: b, or a the other way if b is not convex.
class Cast final : public league::Query {
public:
    explicit Cast(const league_case& asked)
        : Cast(asked, league::is_convex(asked.b.kind) ? asked.a : asked.b,
               league::is_convex(asked.b.kind) ? asked.b : asked.a, league::is_convex(asked.b.kind) ? 1 : -1)
    {
    }

    int answer(const league_case&, league_answer& answer) override
    {
        btCollisionWorld::ClosestConvexResultCallback found(from_.getOrigin(), to_.getOrigin());
        target_.world().convexSweepTest(mover_.convex(), from_, to_, found);
        answer.meet = found.hasHit();
        answer.time = answer.meet ? double(found.m_closestHitFraction) : 0;
        return LEAGUE_ANSWERED;
    }

private:
    Cast(const league_case& asked, const league_body& rests, const league_body& moves, btScalar direction)
        : target_(rests), mover_(moves, false), from_(pose_of(moves)), to_(from_)
    {
        to_.getOrigin() += direction * vector_of(asked.motion);
    }

    Target target_;
    Shape mover_;
    btTransform from_, to_;
};

/// Moves and turns a convex body b. btTransformUtil::integrateTransform() turns by ANGULAR_MOTION_THRESHOLD, an eighth
/// of a turn, at most.
class Turn final : public league::Query {
public:
    explicit Turn(const league_case& asked) : target_(asked.a), mover_(asked.b, false) {}

    int answer(const league_case& asked, league_answer& answer) override
    {
        const int pieces = 1 + int(league::length_of({asked.turn[0], asked.turn[1], asked.turn[2]}) / 0.75);
        for (int k = 0; k < pieces && !answer.meet; ++k) {
            const btTransform from = pose_of(league::b_at(asked, double(k) / pieces)),
                              to = pose_of(league::b_at(asked, double(k + 1) / pieces));
            btCollisionWorld::ClosestConvexResultCallback found(from.getOrigin(), to.getOrigin());
            target_.world().convexSweepTest(mover_.convex(), from, to, found);
            if (!found.hasHit()) continue;
            answer.meet = 1;
            answer.time = (k + double(found.m_closestHitFraction)) / pieces;
            answer.error = error_of(asked, answer.time, found);
        }
        return LEAGUE_ANSWERED;
    }

private:
    /// btContinuousConvexCollision stops at a gap of 0.001 for bodies of all sizes. This is the time in which b closes
    /// it, if it keeps its speed at the point of the hit.
    double error_of(const league_case& asked, double time,
                    const btCollisionWorld::ClosestConvexResultCallback& found) const
    {
        const btVector3 motion = vector_of(asked.motion), turn = vector_of(asked.turn),
                        origin = vector_of(asked.b.position) + btScalar(time) * motion,
                        speed = motion + turn.cross(found.m_hitPointWorld - origin);
        const btScalar closing = -speed.dot(found.m_hitNormalWorld),
                       most = motion.length() + turn.length() * mover_.get()->getAngularMotionDisc();
        const btScalar gap = btScalar(0.001);
        return double(gap / btMax(closing, most / 100)); // A slow end says little about the time.
    }

    Target target_;
    Shape mover_;
};

class Ray final : public league::Query {
public:
    explicit Ray(const league_case& asked)
        : target_(asked.a), from_(vector_of(asked.from)), to_(from_ + vector_of(asked.motion))
    {
    }

    int answer(const league_case&, league_answer& answer) override
    {
        btCollisionWorld::ClosestRayResultCallback found(from_, to_);
        target_.world().rayTest(from_, to_, found);
        answer.meet = found.hasHit();
        answer.time = answer.meet ? double(found.m_closestHitFraction) : 0;
        return LEAGUE_ANSWERED;
    }

private:
    Target target_;
    btVector3 from_, to_;
};

class Boxes final : public league::Query {
public:
    explicit Boxes(const league_case& asked)
    {
        broad_.m_deferedcollide = true; // It finds all pairs at once, when it is queried for them.
        for (std::size_t i = 0; i < asked.body_count; ++i) {
            const btVector3 middle = vector_of(asked.bodies[i].position), half = vector_of(asked.bodies[i].size);
            proxies_.push_back(broad_.createProxy(middle - half, middle + half, 0, reinterpret_cast<void*>(i),
                                                  btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter,
                                                  nullptr));
        }
    }
    ~Boxes() override
    {
        for (btBroadphaseProxy* proxy : proxies_) broad_.destroyProxy(proxy, nullptr);
    }

    int answer(const league_case&, league_answer& answer) override
    {
        broad_.calculateOverlappingPairs(nullptr);
        const btBroadphasePairArray& found = broad_.getOverlappingPairCache()->getOverlappingPairArray();
        pairs_.clear();
        for (int k = 0; k < found.size(); ++k)
            for (const btBroadphaseProxy* proxy : {found[k].m_pProxy0, found[k].m_pProxy1})
                pairs_.push_back(std::uint32_t(reinterpret_cast<std::uintptr_t>(proxy->m_clientObject)));
        answer.pair_count = pairs_.size() / 2;
        answer.pairs = pairs_.data();
        return LEAGUE_ANSWERED;
    }

private:
    btDbvtBroadphase broad_;
    std::vector<btBroadphaseProxy*> proxies_;
    std::vector<std::uint32_t> pairs_;
};

std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    if (league::needs_inside(asked)) return nullptr;
    const int a = asked.a.kind, b = asked.b.kind;
    const bool has_plane = a == LEAGUE_HALF_SPACE || b == LEAGUE_HALF_SPACE;
    const bool has_mesh = league::has_triangles(a) || league::has_triangles(b);
    const bool has_meshes = league::has_triangles(a) && league::has_triangles(b);
    switch (asked.question) {
    case LEAGUE_MEET:
        if (has_meshes || (has_mesh && has_plane)) return std::make_unique<Step>(asked, true);
        return std::make_unique<Contact>(asked);
    case LEAGUE_CONTACTS:
        return std::make_unique<Step>(asked, has_meshes || (has_mesh && has_plane));
    case LEAGUE_DISTANCE:
        return std::make_unique<Points>(asked);
    case LEAGUE_DEPTH:
        if (has_plane) return std::make_unique<Contact>(asked);
        return std::make_unique<Points>(asked);
    case LEAGUE_CAST:
        return std::make_unique<Cast>(asked);
    case LEAGUE_TURN:
        return std::make_unique<Turn>(asked);
    case LEAGUE_RAY:
        return std::make_unique<Ray>(asked);
    default:
        return std::make_unique<Boxes>(asked);
    }
}

constexpr league_library libraries[] = {league::library_of<prepare>({
    .name = "bullet",
    .settings = "3.24, single precision; margins 0; contactPairTest(), btGjkPairDetector with "
                "btGjkEpaPenetrationDepthSolver, convexSweepTest() (turns: in pieces of .75 rad, to a gap of 0.001), "
                "rayTest(), btDbvtBroadphase; "
                "contacts: one performDiscreteCollisionDetection() with multipoint iterations, polyhedral features and "
                "btAdjustInternalEdgeContacts(); meshes: btBvhTriangleMeshShape, with another or a plane "
                "btGImpactMeshShape and "
                "performDiscreteCollisionDetection(); cells: btCompoundShape of boxes",
    .source = "BulletCollision/CollisionDispatch/btCollisionWorld.h, "
              "btDefaultCollisionConfiguration.h, btInternalEdgeUtility.h, "
              "NarrowPhaseCollision/btDiscreteCollisionDetectorInterface.h, "
              "CollisionShapes/btPolyhedralConvexShape.h",
    .supports = supports,
    .bits = 8 * sizeof(btScalar),
    .precision = 1e-4, // MAX_CONVEX_CAST_EPSILON; EPA_ACCURACY
})};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
