// A world of DART with one of four detectors, and what it does in a run.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "../tests/scenes.hpp"
#include "pictures.hpp"

namespace dart::collision::oncollide_client::bench {

/// Processor time of the process, seconds.
double seconds();

/// Time and calls of collide().
struct Clock {
    double seconds = 0;
    std::size_t calls = 0;
};

/// Names for make_detector().
extern const std::vector<std::string> detectors;
/// A detector whose collide() adds to the clock. Throws std::invalid_argument that lists the names.
std::shared_ptr<CollisionDetector> make_detector(const std::string& name, Clock& clock);

/// A measured number: name and unit, value.
using Measures = std::vector<std::pair<std::string, double>>;

/// How long a run may be.
struct Limits {
    double budget = 10; ///< seconds of processor time for one run
    double scale = 1;   ///< of the simulated time of all scenes
};

/// One world, 1 ms steps.
class Run {
public:
    explicit Run(const std::string& detector, const Eigen::Vector3d& gravity = {0, 0, -9.81});
    ~Run();
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    dynamics::BodyNode* add(const dynamics::SkeletonPtr& skeleton);
    /// Steps until the simulated time or the budget ends, or a pose is not finite; `look` is called after each step and
    /// its time is not counted.
    void play(double simulated, const Limits& limits, const std::function<void()>& look = {});
    double time() const { return world_->getTime(); }
    const CollisionResult& contacts() const { return world_->getLastCollisionResult(); }
    /// Adds all bodies as they are now. A body with a name that begins with "front" is left out.
    void show(View& view) const;
    /// Steps, milliseconds per step and per collide(), contacts, contacts per pair, failures of the solver.
    Measures common() const;

private:
    struct Counted;
    void count();

    Clock clock_;
    simulation::WorldPtr world_;
    std::shared_ptr<Counted> fallback_;
    std::vector<dynamics::BodyNode*> bodies_;
    std::size_t steps_ = 0, contacts_ = 0, pairs_ = 0, most_ = 0;
    double seconds_ = 0;
    bool finite_ = true;
};

/// A closed mesh at its centre of mass, with mass and inertia at 1,000 kg/m^3.
struct SolidMesh {
    oncollide::Mesh mesh;
    double mass;
    Eigen::Matrix3d inertia;
    Eigen::Vector3d moved; ///< its centre of mass was here
};
SolidMesh solid(oncollide::Mesh mesh);

} // namespace dart::collision::oncollide_client::bench
