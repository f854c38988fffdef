#include "verify/trials/hard_trials.hpp"

#include <map>

#include <fmt/format.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/runs/pipeline.hpp>

#include "truth/judge.hpp"
#include "truth/setting_variants.hpp"

namespace oncollide::tools {
namespace {

Scene crowd_of(const std::vector<BodyCase>& cases)
{
    Scene scene;
    for (std::size_t k = 0; k < cases.size(); ++k) {
        const BodyCase& c = cases[k];
        const auto add = [&](const char* which, const Mesh& mesh, const Eigen::Isometry3d& pose) {
            const std::string name = fmt::format("{} {}", k, which);
            scene.add_body({.name = name, .geometry = scene.add(name, mesh), .pose = pose});
        };
        add("a", c.a, c.pose_a), add("b", c.b, c.poses_b.front());
    }
    return scene;
}

class Crowd {
public:
    Crowd(const std::vector<BodyCase>& cases, Mode mode) : cases_(cases), scene_(crowd_of(cases))
    {
        for (const BodyCase& c : cases) truths_.push_back(truth_of(c.a, c.pose_a, c.b, c.poses_b.front()));
        tally_.family = mode == Mode::solid ? "all solids at once" : "all of them at once";
        tally_.cases = cases.size();
    }

    /// The first run of each `kind` of settings gives the hash that the other runs must reproduce.
    void run(const std::string& kind, const std::string& name, const Settings& settings)
    {
        Pipeline pipeline(scene_, settings);
        for (int frame = 0; frame < 2; ++frame) {
            std::vector<Finding> findings(cases_.size(), unlisted(settings));
            for (const PairResult& pair : pipeline.step(scene_).pairs)
                if (index(pair.b) == index(pair.a) + 1 && index(pair.a) % 2 == 0) findings[index(pair.a) / 2] = pair;
            judge_all(findings, settings, fmt::format("{}, {}", kind, name));
        }
        const auto [first, fresh] = hashes_.try_emplace(kind, pipeline.hash());
        if (!fresh && first->second != pipeline.hash())
            tally_.fault(&Tally::changed, fmt::format("{}, {}: the result hash differs from the run with one "
                                                      "thread",
                                                      kind, name));
    }

    void run_queries(ExactLevel exact, int threads)
    {
        const Settings settings{.exact = exact, .threads = threads};
        World world(settings);
        std::vector<PairOfModels> pairs;
        for (const BodyCase& c : cases_)
            pairs.push_back({{world.models().add(c.a), c.pose_a}, {world.models().add(c.b), c.poses_b.front()}});
        std::vector<Finding> answers(pairs.size());
        world.pairs().decide(pairs, answers);
        judge_all(answers, settings, fmt::format("pairs of models, exact {}", name_of(exact)));
    }

    const Tally& tally() const { return tally_; }

private:
    void judge_all(std::span<const Finding> findings, const Settings& settings, const std::string& how)
    {
        for (std::size_t k = 0; k < cases_.size(); ++k)
            judge(findings[k], truths_[k], settings,
                  fmt::format("{}: {}, in the crowd: {}", cases_[k].family, cases_[k].name, how), tally_);
    }

    const std::vector<BodyCase>& cases_;
    Scene scene_;
    std::vector<PairTruth> truths_;
    std::map<std::string, std::uint64_t> hashes_;
    Tally tally_;
};

} // namespace

Tally try_crowd(const std::vector<BodyCase>& cases, Mode mode, std::span<const int> threads, bool gpu)
{
    Crowd crowd(cases, mode);
    constexpr ExactLevel levels[] = {ExactLevel::off, ExactLevel::predicates};
    const Settings base{.depth = 5, .mode = mode, .open_as_surface = mode == Mode::solid};
    for (auto& [kind, settings] : levels_and_volumes(levels, base)) {
        for (int n : threads) {
            settings.threads = n;
            crowd.run(kind, fmt::format("{} threads", n), settings);
        }
        for (BroadPhaseKind broad : {BroadPhaseKind::octree, BroadPhaseKind::brute_force}) {
            settings.broad_phase = broad;
            crowd.run(kind, std::string(name_of(broad)), settings);
        }
        if (!gpu) continue;
        const bool spheres = settings.bounding_volume == BoundingVolume::sphere;
        settings.backend = spheres ? BackendKind::gl_compute : BackendKind::gl;
        crowd.run(kind, std::string(name_of(settings.backend)), settings);
    }
    if (mode == Mode::surface)
        for (ExactLevel exact : levels)
            for (int n : threads) crowd.run_queries(exact, n);
    return crowd.tally();
}

} // namespace oncollide::tools
