#include "measure.hpp"

#include <cmath>
#include <ctime>
#include <map>
#include <stdexcept>

#include <dart/collision/bullet/bullet.hpp>
#include <dart/collision/ode/ode.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>

namespace dart::collision::oncollide_client::bench {

double seconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

namespace {

template <class Detector>
class Timed final : public Detector {
public:
    template <class... Args>
    explicit Timed(Clock& clock, Args&&... args) : Detector(std::forward<Args>(args)...), clock_(clock)
    {
    }
    using Detector::collide;
    bool collide(CollisionGroup* group, const CollisionOption& option, CollisionResult* result) override
    {
        const double before = seconds();
        const bool found = Detector::collide(group, option, result);
        clock_.seconds += seconds() - before, ++clock_.calls;
        return found;
    }

private:
    Clock& clock_;
};

} // namespace

const std::vector<std::string> detectors{"fcl", "bullet", "ode", "oncollide"};

std::shared_ptr<CollisionDetector> make_detector(const std::string& name, Clock& clock)
{
    if (name == "fcl") return std::make_shared<Timed<FCLCollisionDetector>>(clock); // meshes, as in DART's solver
    if (name == "bullet") return std::make_shared<Timed<BulletCollisionDetector>>(clock);
    if (name == "ode") return std::make_shared<Timed<OdeCollisionDetector>>(clock);
    if (name == "oncollide") return std::make_shared<Timed<OncollideCollisionDetector>>(clock, OncollideOptions());
    throw std::invalid_argument("no detector '" + name + "'; there are: fcl, bullet, ode, oncollide");
}

/// Is called where Dantzig's method fails.
struct Run::Counted final : constraint::PgsBoxedLcpSolver {
    std::size_t calls = 0;
    bool solve(int n, double* A, double* x, double* b, int nub, double* lo, double* hi, int* findex,
               bool early_end) override
    {
        ++calls;
        return PgsBoxedLcpSolver::solve(n, A, x, b, nub, lo, hi, findex, early_end);
    }
};

Run::Run(const std::string& detector, const Eigen::Vector3d& gravity)
    : world_(simulation::World::create()), fallback_(std::make_shared<Counted>())
{
    world_->setConstraintSolver(std::make_unique<constraint::BoxedLcpConstraintSolver>(
        std::make_shared<constraint::DantzigBoxedLcpSolver>(), fallback_));
    world_->getConstraintSolver()->setCollisionDetector(make_detector(detector, clock_));
    world_->setGravity(gravity);
    world_->setTimeStep(1e-3);
}

Run::~Run() = default;

dynamics::BodyNode* Run::add(const dynamics::SkeletonPtr& skeleton)
{
    world_->addSkeleton(skeleton);
    bodies_.push_back(skeleton->getRootBodyNode());
    return bodies_.back();
}

void Run::play(double simulated, const Limits& limits, const std::function<void()>& look)
{
    const double until = time() + simulated * limits.scale - 5e-4;
    while (finite_ && time() < until && seconds_ < limits.budget) {
        const double before = seconds();
        world_->step();
        seconds_ += seconds() - before, ++steps_;
        count();
        if (look && finite_) look();
    }
}

void Run::count()
{
    std::map<std::pair<const CollisionObject*, const CollisionObject*>, std::size_t> pairs;
    for (const Contact& contact : contacts().getContacts())
        ++pairs[std::minmax<const CollisionObject*>(contact.collisionObject1, contact.collisionObject2)];
    contacts_ += contacts().getNumContacts(), pairs_ += pairs.size();
    for (const auto& [pair, n] : pairs) most_ = std::max(most_, n);
    for (const dynamics::BodyNode* body : bodies_) finite_ = finite_ && body->getTransform().matrix().allFinite();
}

void Run::show(View& view) const
{
    for (const dynamics::BodyNode* body : bodies_) {
        if (body->getSkeleton()->getName().starts_with("front")) continue;
        const bool fixed = body->getParentJoint()->getNumDofs() == 0;
        for (const dynamics::ShapeNode* node : body->getShapeNodesWith<dynamics::CollisionAspect>())
            view.add(*node->getShape(), node->getTransform(), fixed ? View::Role::fixed : View::Role::moving);
    }
}

Measures Run::common() const
{
    const double steps = double(std::max<std::size_t>(steps_, 1));
    return {{"simulated s", time()},
            {"step ms", 1e3 * seconds_ / steps},
            {"detection ms", 1e3 * clock_.seconds / double(std::max<std::size_t>(clock_.calls, 1))},
            {"contacts", double(contacts_) / steps},
            {"contacts of a pair, mean", double(contacts_) / double(std::max<std::size_t>(pairs_, 1))},
            {"contacts of a pair, most", double(most_)},
            {"failures of the solver", double(fallback_->calls) + (finite_ ? 0 : 1)}};
}

SolidMesh solid(oncollide::Mesh mesh)
{
    double volume = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero(); // integral of x x^T, over tetrahedra with the origin
    for (const oncollide::Triangle& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]], s = a + b + c;
        const double v = a.dot(b.cross(c)) / 6;
        volume += v, moment += v / 4 * s;
        second += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    }
    const double density = volume < 0 ? -1000 : 1000; // negative: the triangles face inward
    SolidMesh made{{}, density * volume, {}, moment / volume};
    second -= volume * made.moved * made.moved.transpose();
    made.inertia = density * (second.trace() * Eigen::Matrix3d::Identity() - second);
    for (Eigen::Vector3d& v : mesh.vertices) v -= made.moved;
    made.mesh = oncollide::make_mesh("solid", std::move(mesh.vertices), std::move(mesh.triangles));
    return made;
}

} // namespace dart::collision::oncollide_client::bench
