#include "study/play.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

constexpr std::size_t most_errors = 10; ///< listed per peer

} // namespace

void judge(StudyRow& row, std::span<const PairResult> answer, SceneTruth& truth, const Scene& scene, int frame,
           std::size_t bounds)
{
    for (const PairResult& pair : answer) {
        ++row.verdicts[std::size_t(pair.verdict)];
        if (pair.verdict != Verdict::separate) row.error = std::max(row.error, pair.bound);
    }
    Settings settings = row.variant.settings; // without an exact level, touching pairs are left over: false positives
    settings.ignore_touching = truth.request().ignore_touching;
    row += judge(answer, truth, scene, settings,
                 {.bounds = bounds,
                  .start = std::size_t(frame),
                  .false_positives = true,
                  .look = [&](BodyPair pair, const Finding& result, const Judgement& judgement) {
                      const Sighting found{frame, pair, truth.distance(pair).high, result.bound};
                      if (judgement.fault == Judgement::Fault::missed && !row.first_miss) row.first_miss = found;
                      if (!judgement.false_positive) return;
                      row.false_positive_distances.push_back(found.distance);
                      const double share = found.bound > 0 ? found.distance / found.bound : 0;
                      ++row.false_positives_by_share[std::min(false_positive_bins - 1,
                                                              std::size_t(share * double(false_positive_bins)))];
                      if (!row.worst_false_positive || found.distance > row.worst_false_positive->distance)
                          row.worst_false_positive = found;
                  }});
}

void judge(StudyPeer& peer, std::span<const BodyPair> colliding, SceneTruth& truth, const Scene& scene, int number)
{
    peer.colliding += colliding.size();
    const auto tell = [&](BodyPair pair, std::string_view what) {
        if (peer.errors.size() < most_errors)
            peer.errors.push_back(fmt::format("frame {}: {} {} and {}", number, what, scene.label(SceneBodyId{pair.a}),
                                              scene.label(SceneBodyId{pair.b})));
    };
    for (BodyPair pair : truth.colliding())
        if (!std::ranges::binary_search(colliding, pair)) ++peer.missed, tell(pair, "misses");
    for (BodyPair pair : colliding)
        if (!truth.collide(pair)) {
            ++peer.invented;
            tell(pair, fmt::format("reports as colliding, though {:.3g} m apart,", truth.distance(pair).high));
        }
}

} // namespace oncollide::tools
