#include "study/continuous/continuous_study.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/runs/pipeline.hpp>

#include "cli/progress.hpp"
#include "common/statistics.hpp"
#include "fcl/fcl_pair.hpp"
#include "render/flat_picture.hpp"
#include "render/framing.hpp"
#include "render/render_scene.hpp"
#include "study/play.hpp"

namespace oncollide::tools {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
const Settings exact_tests{.exact = ExactLevel::predicates};

/// Steps of pairs whose boxes on the way overlap and that no gap rules out; of more than `most`, an even choice.
std::vector<StepOfPair> steps_of(StudyWorkload& workload, std::size_t most, std::size_t& all)
{
    std::vector<StepOfPair> steps;
    workload.move(0);
    Pipeline pipeline(workload.scene, exact_tests);
    pipeline.set_continuous(true);
    Progress progress("frame", std::size_t(workload.frames()));
    for (int frame = 0; frame < workload.frames(); ++frame) {
        const std::vector<Eigen::Isometry3d> before(workload.scene.poses.begin(), workload.scene.poses.end());
        const double time = workload.scene.time;
        workload.move(frame);
        const FrameView view = pipeline.step(workload.scene);
        for (const PairSweep& sweep : view.sweeps) {
            if (sweep.contact_by == 0 || (sweep.verdict == Verdict::separate && sweep.steps == 0)) continue;
            const BodyPair pair{index(view.pairs[sweep.pair].a), index(view.pairs[sweep.pair].b)};
            const auto way = [&](std::uint32_t body) {
                const Scene& scene = workload.scene;
                const auto keys = way_between(scene.motions[body], time, scene.time, before[body], scene.poses[body]);
                return keys.empty() ? RigidMotion(before[body]) : RigidMotion(keys);
            };
            StepOfPair step{pair, workload.number(frame), way(pair.a), way(pair.b)};
            ++all;
            const auto place = std::size_t(u01(1, all, 0) * double(all));
            if (steps.size() < most)
                steps.push_back(std::move(step));
            else if (place < most)
                steps[place] = std::move(step);
        }
        progress.step();
    }
    return steps;
}

/// Takes one step in every way.
class Contenders {
public:
    Contenders(const Scene& scene, const ContinuousOptions& options, ContinuousStudy& study)
        : scene_(scene), options_(options), study_(study), pipeline_(scene, exact_tests)
    {
        for (const double tolerance : options.tolerances)
            study.rows.push_back({"oncollide", fmt::format("tolerance {:g}", tolerance), tolerance});
        for (const int samples : options.samples)
            study.rows.push_back(
                {"sampled", fmt::format("{} pose{} a step", samples, samples == 1 ? "" : "s"), 1.0 / samples});
        if (options.of_fcl == 0) return;
        study.rows.push_back({"FCL", "default: sampled", 0.1});
        study.rows.push_back({"FCL", "conservative advancement", options.tolerances.back()});
    }
    SweepResult sweep(const StepOfPair& step, double tolerance) const
    {
        return world().pairs().sweep(
            moving(step.pair.a, step.motion_a), moving(step.pair.b, step.motion_b),
            {.time_tolerance = tolerance, .gap_tolerance = std::max(tolerance * study_.size, 1e-12)});
    }
    void take(std::size_t number)
    {
        const StepOfPair& step = study_.pairs[number];
        auto row = study_.rows.begin();
        for (const double tolerance : options_.tolerances)
            timed(*row++, step, [&] {
                const SweepResult found = sweep(step, tolerance);
                return found.verdict == Verdict::separate ? never : found.contact_by;
            });
        for (const int samples : options_.samples) {
            const std::uint64_t missed = row->missed;
            const double time = timed(*row, step, [&] { return first_sample(step, samples); });
            study_.contradicted += time < step.truth.clear_until;
            if (row->missed > missed && (!study_.worst || samples > study_.worst->samples))
                study_.worst = {number, samples};
            ++row;
        }
        if (row != study_.rows.end() && taken_ < options_.of_fcl && is_mesh(step.pair.a) && is_mesh(step.pair.b)) {
            ++taken_;
            for (const FclSweep how : {FclSweep::sampled, FclSweep::advancement})
                timed(*row++, step, [&] { return of_fcl(step, how); });
        }
    }

private:
    const World& world() const { return pipeline_.world(); }
    ModelId model(std::uint32_t body) const { return pipeline_.model(scene_.geometry[body]); }
    MovingModel moving(std::uint32_t body, const RigidMotion& motion) const { return {model(body), motion}; }
    const Mesh* is_mesh(std::uint32_t body) const
    {
        return std::get_if<Mesh>(&scene_.geometries[index(scene_.geometry[body])].data);
    }
    static double timed(ContinuousRow& row, const StepOfPair& step, auto work)
    {
        const auto from = Clock::now();
        const double time = work();
        row.us.push_back(1000 * milliseconds_since(from));
        row.add(time, step);
        return time;
    }
    double first_sample(const StepOfPair& step, int samples) const
    {
        for (int k = 1; k <= samples; ++k) {
            const double time = double(k) / samples;
            const PlacedModel a{model(step.pair.a), step.motion_a.pose(time)},
                b{model(step.pair.b), step.motion_b.pose(time)};
            if (world().pairs().decide(a, b).verdict == Verdict::colliding) return time;
        }
        return never;
    }
    const FclGeometry& fcl(std::uint32_t body)
    {
        FclGeometry& made = fcl_[index(scene_.geometry[body])];
        if (!made) made = make_fcl_geometry(*is_mesh(body), FclNodes::obbrss);
        return made;
    }
    double of_fcl(const StepOfPair& step, FclSweep how)
    {
        return fcl_time_of_contact({fcl(step.pair.a), step.motion_a.pose(0)}, step.motion_a.pose(1),
                                   {fcl(step.pair.b), step.motion_b.pose(0)}, step.motion_b.pose(1), how,
                                   options_.tolerances.back());
    }

    const Scene& scene_;
    const ContinuousOptions& options_;
    ContinuousStudy& study_;
    Pipeline pipeline_;
    std::map<std::uint32_t, FclGeometry> fcl_;
    std::size_t taken_ = 0; ///< steps that FCL took
};

} // namespace

void ContinuousRow::add(double time, const StepOfPair& step)
{
    if (step.is_open()) return;
    const bool found = time < never;
    contacts += found;
    if (step.meets())
        missed += !found;
    else
        invented += found;
    if (found && step.meets()) latest = std::max(latest, time - step.truth.contact_by);
}

ContinuousStudy play_continuous(StudyWorkload& workload, const ContinuousOptions& options)
{
    ContinuousStudy study;
    study.title = workload.title, study.bodies = workload.scene.size(), study.frames = workload.frames();
    const double size = median_size(workload.scene);
    if (size > 0 && std::isfinite(size)) study.size = size;
    study.pairs = steps_of(workload, options.count, study.steps);
    Contenders contenders(workload.scene, options, study);
    Progress progress("step", study.pairs.size());
    for (std::size_t i = 0; i < study.pairs.size(); ++i) {
        StepOfPair& step = study.pairs[i];
        step.truth = contenders.sweep(step, options.tolerances.back());
        study.contacts += step.meets(), study.open += step.is_open();
        contenders.take(i);
        progress.step();
    }
    return study;
}

std::optional<PagePicture> draw_worst_miss(const Scene& scene, const ContinuousStudy& study)
{
    constexpr int side = 480; // pixels, of each of the two panels
    if (!study.worst) return {};
    const StepOfPair& step = study.pairs[study.worst->step];
    const double time = step.truth.contact_by;
    Scene two;
    for (const auto& [body, motion] :
         {std::pair(step.pair.a, &step.motion_a), std::pair(step.pair.b, &step.motion_b)}) {
        const GeometryId geometry =
            two.add(fmt::format("{}", body), scene.geometries[index(scene.geometry[body])].data);
        two.add_body({.geometry = geometry, .pose = motion->pose(time)});
    }
    Pipeline pipeline(two, exact_tests);
    const FrameView frame = pipeline.step(two);
    ScenePictures pictures(
        two, {.meshes = true, .spheres = false, .bodies = std::vector<std::uint8_t>(2, 1), .meeting = true});
    ScenePicture picture = pictures.make(pipeline.world(), {}, frame.pairs, std::nullopt);
    picture.width = picture.height = side;
    Framing framing(side, side);
    framing.add(picture);
    picture.camera = framing.camera();
    Image image = blank(2 * side, side);
    paste(draw_bodies(picture).pixels, side, image, 0);
    const Eigen::Vector3d place = step.truth.contact.middle(),
                          back = (picture.camera.eye - picture.camera.look_at).normalized();
    picture.camera.look_at = place, picture.camera.eye = place + 0.3 * framing.bounds().diagonal() * back;
    paste(draw_bodies(picture).pixels, side, image, side);
    return PagePicture{fmt::format("{} and {} on their way to frame {}: in contact at {:.9g} of the step, apart in all "
                                   "{} sampled poses.",
                                   scene.label(SceneBodyId{step.pair.a}), scene.label(SceneBodyId{step.pair.b}),
                                   step.frame, time, study.worst->samples),
                       packed_png(image)};
}

} // namespace oncollide::tools
