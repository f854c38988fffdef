#include "verify/trials/hard_trials.hpp"

#include <fmt/format.h>

#include <oncollide/pipeline/world.hpp>

#include "verify/cases/drawn_scene.hpp"
#include "verify/cases/placed_body.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

class ApproachTrial {
public:
    ApproachTrial(std::uint64_t number, Tally& tally)
        : number_(number), tally_(tally), draw_(number), geometries_(draw_sweep(number))
    {
    }

    void run()
    {
        Isometry3d pose_a = Isometry3d::Identity(), pose_b = pose_a;
        pose_a.linear() = attitude(), pose_b.linear() = attitude();
        pose_b.translation() = draw_.vector(), pose_a.translation() = 20 * draw_.vector().normalized();
        const BodyId a = now_.bodies().add({.model = add_model(now_, geometries_.a), .pose = pose_a}),
                     b = now_.bodies().add({.model = add_model(now_, geometries_.b), .pose = pose_b});
        if (!approach(a, b, pose_a)) return;
        const BodyId live_a = live_.bodies().add({.model = add_model(live_, geometries_.a), .pose = pose_a});
        live_.bodies().add({.model = add_model(live_, geometries_.b), .pose = pose_b});
        live_.step(), live_.step();
        ++tally_.cases;
        for (int move = 0; move < 6; ++move) {
            const Finding found = now_.pairs().decide(a, b);
            const Distance distance = now_.pairs().distance(a, b);
            tally_.bounds += 2;
            if (found.verdict == Verdict::colliding && distance.upper != 0)
                fault(&Tally::broken, move, fmt::format("collide at a distance of {:.3g} m", distance.upper));
            if (found.verdict == Verdict::separate && found.bound > distance.upper * (1 + 1e-9) + 1e-14)
                fault(&Tally::broken, move,
                      fmt::format("bound {:.17g}, distance {:.17g}", found.bound, distance.upper));
            Vector3d toward = distance.point_b - distance.point_a;
            toward = toward.norm() > 0 ? Vector3d(toward.normalized()) : draw_.vector();
            const double step = std::max(found.bound, 1e-12) * draw_.real(-0.5, 2);
            pose_a.translation() += step * (toward + draw_.number(0, 1) * draw_.vector());
            if (draw_.number(0, 2) == 0)
                pose_a.linear() = Matrix3d(Eigen::AngleAxisd(step * draw_.real(-1, 1), draw_.vector().normalized()) *
                                           pose_a.linear());
            now_.bodies().set_pose(a, pose_a), live_.bodies().set_pose(live_a, pose_a);
            const FrameView frame = live_.step();
            const Verdict stepped = frame.pairs.empty() ? Verdict::separate : frame.pairs[0].verdict,
                          decided = now_.pairs().decide(a, b).verdict;
            ++tally_.results;
            // Where rounding leaves round bodies undecided, one of them may still be certain.
            if (stepped != decided && stepped != Verdict::within && decided != Verdict::within)
                fault(decided == Verdict::colliding ? &Tally::missed : &Tally::changed, move,
                      fmt::format("step() says {}, decide() {}", name_of(stepped), name_of(decided)));
        }
    }

private:
    Matrix3d attitude()
    {
        if (draw_.number(0, 1)) return draw_.rotation();
        const double lean = draw_.number(0, 2) ? draw_.magnitude(-50, 0) : 0;
        return Eigen::AngleAxisd(lean, draw_.vector().normalized()).toRotationMatrix();
    }
    /// Moves a towards b, to a random small distance. False if they met, or if neither is bounded.
    bool approach(BodyId a, BodyId b, Isometry3d& pose)
    {
        for (int step = 0; step < 60; ++step) {
            const Distance distance = now_.pairs().distance(a, b);
            const Vector3d between = distance.point_b - distance.point_a;
            if (distance.upper == 0) return false;
            const double wanted = draw_.magnitude(-43, -6);
            if (distance.lower < 4 * wanted || !(between.norm() > 0)) return distance.upper < 0.1;
            pose.translation() += 0.999 * (distance.lower - wanted) * between.normalized();
            now_.bodies().set_pose(a, pose);
        }
        return true;
    }
    void fault(std::uint64_t Tally::*kind, int move, const std::string& what)
    {
        tally_.fault(kind, fmt::format("pair {}, move {}: {}", number_, move, what));
    }

    const std::uint64_t number_;
    Tally& tally_;
    CaseNumbers draw_;
    const DrawnSweep geometries_;
    World now_, live_;
};

} // namespace

Tally try_approaches(std::uint64_t count, int threads)
{
    return try_many(approach_family, count, threads,
                    [](std::uint64_t number, Tally& tally) { ApproachTrial(number, tally).run(); });
}

} // namespace oncollide::tools
