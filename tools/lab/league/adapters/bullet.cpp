// Bullet's collision world and its tests of two convex shapes.
#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
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
        return known && !planes;
    case LEAGUE_DISTANCE:
        return league::is_convex(a) && league::is_convex(b);
    case LEAGUE_DEPTH:
        return (league::is_convex(a) && (league::is_convex(b) || b == LEAGUE_HALF_SPACE)) ||
               (a == LEAGUE_HALF_SPACE && league::is_convex(b));
    case LEAGUE_CAST:
        return known && (league::is_convex(a) || league::is_convex(b));
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

struct Query {
    virtual ~Query() = default;
    virtual int answer(league_answer& answer) = 0;
};

/// Finds the deepest contact of two bodies.
class Contact final : public Query {
public:
    explicit Contact(const league_case& asked)
        : a_(asked.a, false), b_(asked.b, false), depth_(asked.question == LEAGUE_DEPTH)
    {
        object_a_.setCollisionShape(a_.get()), object_a_.setWorldTransform(pose_of(asked.a));
        object_b_.setCollisionShape(b_.get()), object_b_.setWorldTransform(pose_of(asked.b));
    }

    int answer(league_answer& answer) override
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

/// Lets a mesh in GImpact's form meet another, or a plane. contactPairTest() queries for algorithms of closest points,
/// which GImpact lacks.
class MeshContact final : public Query {
public:
    explicit MeshContact(const league_case& asked) : a_(asked.a, true), b_(asked.b, true)
    {
        object_a_.setCollisionShape(a_.get()), object_a_.setWorldTransform(pose_of(asked.a));
        object_b_.setCollisionShape(b_.get()), object_b_.setWorldTransform(pose_of(asked.b));
        world_.world.addCollisionObject(&object_a_), world_.world.addCollisionObject(&object_b_);
    }
    ~MeshContact() override
    {
        world_.world.removeCollisionObject(&object_a_), world_.world.removeCollisionObject(&object_b_);
    }
    MeshContact(const MeshContact&) = delete;
    MeshContact& operator=(const MeshContact&) = delete;

    int answer(league_answer& answer) override
    {
        world_.world.performDiscreteCollisionDetection();
        for (int i = 0; i < world_.dispatcher.getNumManifolds(); ++i) {
            const btPersistentManifold& manifold = *world_.dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold.getNumContacts(); ++k)
                if (manifold.getContactPoint(k).getDistance() <= 0) answer.meet = 1;
        }
        return LEAGUE_ANSWERED;
    }

private:
    Shape a_, b_;
    btCollisionObject object_a_, object_b_;
    World world_;
};

/// Finds the nearest or the deepest points of two convex bodies.
class Points final : public Query {
public:
    explicit Points(const league_case& asked)
        : a_(asked.a, false), b_(asked.b, false), depth_(asked.question == LEAGUE_DEPTH)
    {
        input_.m_transformA = pose_of(asked.a), input_.m_transformB = pose_of(asked.b);
    }

    int answer(league_answer& answer) override
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
class Cast final : public Query {
public:
    explicit Cast(const league_case& asked)
        : Cast(asked, league::is_convex(asked.b.kind) ? asked.a : asked.b,
               league::is_convex(asked.b.kind) ? asked.b : asked.a, league::is_convex(asked.b.kind) ? 1 : -1)
    {
    }

    int answer(league_answer& answer) override
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

class Ray final : public Query {
public:
    explicit Ray(const league_case& asked)
        : target_(asked.a), from_(vector_of(asked.from)), to_(from_ + vector_of(asked.motion))
    {
    }

    int answer(league_answer& answer) override
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

class Boxes final : public Query {
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
    Boxes(const Boxes&) = delete;
    Boxes& operator=(const Boxes&) = delete;

    int answer(league_answer& answer) override
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

std::unique_ptr<Query> make_query(const league_case& asked)
{
    const int a = asked.a.kind, b = asked.b.kind;
    const bool has_plane = a == LEAGUE_HALF_SPACE || b == LEAGUE_HALF_SPACE;
    const bool has_mesh = league::has_triangles(a) || league::has_triangles(b);
    const bool has_meshes = league::has_triangles(a) && league::has_triangles(b);
    switch (asked.question) {
    case LEAGUE_MEET:
        if (has_meshes || (has_mesh && has_plane)) return std::make_unique<MeshContact>(asked);
        return std::make_unique<Contact>(asked);
    case LEAGUE_DISTANCE:
        return std::make_unique<Points>(asked);
    case LEAGUE_DEPTH:
        if (has_plane) return std::make_unique<Contact>(asked);
        return std::make_unique<Points>(asked);
    case LEAGUE_CAST:
        return std::make_unique<Cast>(asked);
    case LEAGUE_RAY:
        return std::make_unique<Ray>(asked);
    default:
        return std::make_unique<Boxes>(asked);
    }
}

struct Prepared {
    std::unique_ptr<Query> query;
    explicit Prepared(const league_case& asked) : query(make_query(asked)) {}
};

void* prepare(const league_case* asked)
{
    if (!supports(asked->question, asked->a.kind, asked->b.kind)) return nullptr;
    const bool pairs = asked->question == LEAGUE_PAIRS, ray = asked->question == LEAGUE_RAY;
    if (!pairs && (league::is_solid_mesh(asked->a) || (!ray && league::is_solid_mesh(asked->b)))) return nullptr;
    return league::prepared_or_null<Prepared>(*asked);
}

int answer(void* prepared, const league_case*, league_answer* answer)
{
    *answer = {};
    return league::without_exceptions([&] { return static_cast<Prepared*>(prepared)->query->answer(*answer); });
}

void release(void* prepared)
{
    delete static_cast<Prepared*>(prepared);
}

constexpr league_library library{
    .version = LEAGUE_VERSION,
    .bits = 8 * sizeof(btScalar),
    .name = "bullet",
    .settings = "3.24, single precision; margins 0; contactPairTest(), btGjkPairDetector with "
                "btGjkEpaPenetrationDepthSolver, convexSweepTest(), rayTest(), btDbvtBroadphase; meshes: "
                "btBvhTriangleMeshShape, with another or a plane btGImpactMeshShape and "
                "performDiscreteCollisionDetection(); cells: btCompoundShape of boxes",
    .source = "BulletCollision/CollisionDispatch/btCollisionWorld.h, "
              "NarrowPhaseCollision/btDiscreteCollisionDetectorInterface.h",
    .precision = 1e-4, // MAX_CONVEX_CAST_EPSILON; EPA_ACCURACY
    .conservative = 0,
    .supports = supports,
    .prepare = prepare,
    .answer = answer,
    .release = release,
};

} // namespace

const league_library* league_open(int number)
{
    return number == 0 ? &library : nullptr;
}
