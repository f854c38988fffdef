#include "truth/scene_truth.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

#include "truth/near_bodies.hpp"

namespace oncollide::tools {
namespace {

/// Rounding of distances that is not left to the clearance, relative to the bodies' size.
constexpr double open_rounding = 0x1p-36;

} // namespace

SceneTruth::SceneTruth(const Scene& scene, const Settings& request)
    : scene_(scene), request_(request), models_(scene.geometries.size()), apart_{.kinds = false}
{
    apart_.distance.low = request.clearance * (1 + 0x1p-15); // near_bodies() adds more
    for (const GeometryId used : scene.geometry)
        if (std::unique_ptr<TruthModel>& model = models_[index(used)]; !model)
            model = std::make_unique<TruthModel>(scene.geometries[index(used)].data,
                                                 request.mode == Mode::solid || wants_kinds(request));
}

SceneTruth::~SceneTruth() = default;

const TruthModel& SceneTruth::model(std::uint32_t body) const
{
    return *models_[index(scene_.geometry[body])];
}

PairTruth SceneTruth::truth(BodyPair pair, bool distance) const
{
    return truth_of(model(pair.a), scene_.poses[pair.a], model(pair.b), scene_.poses[pair.b],
                    {.kinds = wants_kinds(request_),
                     .deep = request_.ignore_touching,
                     .distance = distance,
                     .within = request_.clearance});
}

void SceneTruth::step()
{
    colliding_.clear(), open_.clear(), far_.clear();
    near_ = near_bodies(scene_, request_.clearance);
    truths_.assign(near_.size(), {});
    parallel_chunks(near_.size(), 8, hardware_threads(), [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) {
            truths_[k] = truth(near_[k], false);
            if (request_.clearance > 0 && !must_be_left_over(truths_[k], request_))
                measure(truths_[k], model(near_[k].a), scene_.poses[near_[k].a], model(near_[k].b),
                        scene_.poses[near_[k].b]);
        }
    });
    Settings touching = request_;
    touching.clearance = 0;
    for (std::size_t k = 0; k < near_.size(); ++k) {
        const PairTruth& truth = truths_[k];
        const double clearance = request_.clearance, rounding = open_rounding * truth.distance.size;
        const bool meet = must_be_left_over(truth, touching);
        const bool unclear = truth.open || (request_.ignore_touching && (truth.vague || !truth.kinds) && truth.collide);
        if (meet || (clearance > 0 && truth.distance.high <= clearance - rounding))
            colliding_.push_back(near_[k]);
        else if (unclear || (clearance > 0 && truth.distance.low <= clearance + rounding))
            open_.push_back(near_[k]);
    }
}

bool SceneTruth::collide(BodyPair pair) const
{
    return std::ranges::binary_search(colliding_, pair);
}

bool SceneTruth::open(BodyPair pair) const
{
    return std::ranges::binary_search(open_, pair);
}

const PairTruth& SceneTruth::of(BodyPair pair) const
{
    const auto at = std::ranges::lower_bound(near_, pair);
    if (at != near_.end() && *at == pair) return truths_[std::size_t(at - near_.begin())];
    const auto far = far_.find(pair);
    return far == far_.end() ? apart_ : far->second;
}

const PairTruth& SceneTruth::measured(BodyPair pair)
{
    const auto at = std::ranges::lower_bound(near_, pair);
    if (at == near_.end() || *at != pair) {
        const auto [far, fresh] = far_.try_emplace(pair);
        if (fresh) far->second = truth(pair, true);
        return far->second;
    }
    PairTruth& known = truths_[std::size_t(at - near_.begin())];
    if (!std::isfinite(known.distance.high))
        measure(known, model(pair.a), scene_.poses[pair.a], model(pair.b), scene_.poses[pair.b]);
    return known;
}

DistanceTruth SceneTruth::distance(BodyPair pair)
{
    DistanceTruth distance = measured(pair).distance;
    const double rounding = open_rounding * distance.size;
    distance.low = std::max(0.0, distance.low - rounding);
    if (distance.high > 0 && !measured(pair).surfaces) distance.high += rounding;
    return distance;
}

std::string names_of(const Scene& scene, BodyPair pair)
{
    return fmt::format("{} and {}", scene.label(SceneBodyId{pair.a}), scene.label(SceneBodyId{pair.b}));
}

FrameJudgement& FrameJudgement::operator+=(const FrameJudgement& o)
{
    missed += o.missed, wrong += o.wrong, false_positives += o.false_positives, bounds += o.bounds, broken += o.broken;
    least_margin = std::min(least_margin, o.least_margin), largest_bound = std::max(largest_bound, o.largest_bound);
    if (first_fault.empty()) first_fault = o.first_fault;
    return *this;
}

FrameJudgement judge(std::span<const PairResult> answer, SceneTruth& truth, const Scene& scene,
                     const Settings& settings, const FrameChecks& checks)
{
    FrameJudgement sum;
    const auto take = [&](BodyPair pair, const Finding& result, bool measure) {
        Judgement judgement = judge(result, measure ? truth.measured(pair) : truth.of(pair), settings);
        if (checks.false_positives && judgement.false_positive)
            judgement = judge(result, truth.measured(pair), settings);
        sum.missed += judgement.fault == Judgement::Fault::missed;
        sum.wrong += judgement.fault == Judgement::Fault::wrong;
        sum.broken += judgement.broken, sum.false_positives += judgement.false_positive;
        if (!judgement.right() && sum.first_fault.empty())
            sum.first_fault =
                fmt::format("{}: {}", names_of(scene, pair), described(result, truth.of(pair), judgement));
        if (checks.look && (!judgement.right() || judgement.false_positive)) checks.look(pair, result, judgement);
    };
    const std::size_t step = std::max<std::size_t>(1, answer.size() / std::max<std::size_t>(checks.bounds, 1));
    auto next = truth.near().begin(); // both lists are sorted
    for (std::size_t i = 0; i < answer.size(); ++i) {
        const PairResult& result = answer[i];
        const BodyPair pair{index(result.a), index(result.b)};
        for (; next != truth.near().end() && *next < pair; ++next) take(*next, unlisted(settings), false);
        if (next != truth.near().end() && *next == pair) ++next;
        const bool check = checks.bounds > 0 && i % step == checks.start % step && result.verdict != Verdict::colliding;
        take(pair, result, check);
        if (!check) continue;
        const DistanceTruth& distance = truth.measured(pair).distance;
        const bool separate = result.verdict == Verdict::separate;
        ++sum.bounds;
        sum.least_margin =
            std::min(sum.least_margin, separate ? distance.high - result.bound : result.bound - distance.low);
        if (result.verdict == Verdict::within) sum.largest_bound = std::max(sum.largest_bound, result.bound);
    }
    for (; next != truth.near().end(); ++next) take(*next, unlisted(settings), false);
    return sum;
}

} // namespace oncollide::tools
