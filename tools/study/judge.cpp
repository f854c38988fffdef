#include "study/play.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

constexpr std::size_t most_errors = 10; ///< listed per peer

void judge_false_positive(StudyRow& row, const Sighting& found, double lower)
{
    ++row.false_positives;
    row.false_positive_distances.push_back(found.distance);
    const double share = found.bound > 0 ? found.distance / found.bound : 0;
    ++row.false_positives_by_share[std::min(false_positive_bins - 1, std::size_t(share * double(false_positive_bins)))];
    row.broken += lower > found.bound;
    if (!row.worst_false_positive || found.distance > row.worst_false_positive->distance)
        row.worst_false_positive = found;
}

} // namespace

void judge(StudyRow& row, std::span<const PairResult> answer, SceneTruth& truth, int frame)
{
    std::uint64_t found = 0;
    for (const PairResult& pair : answer) {
        ++row.verdicts[std::size_t(pair.verdict)];
        if (pair.verdict == Verdict::separate) continue;
        const BodyPair bodies{index(pair.a), index(pair.b)};
        row.error = std::max(row.error, pair.bound);
        if (truth.collide(bodies)) {
            ++found;
        } else if (truth.open(bodies)) {
            continue;
        } else if (pair.verdict == Verdict::colliding) {
            ++row.invented;
        } else {
            const DistanceTruth distance = truth.distance(bodies);
            judge_false_positive(row, {frame, bodies, distance.high, pair.bound}, distance.low);
        }
    }
    if (found == truth.colliding().size()) return;
    row.missed += truth.colliding().size() - found;
    if (row.first_miss) return;
    const auto left_over = [&](BodyPair pair) {
        return std::ranges::any_of(answer, [&](const PairResult& p) {
            return BodyPair{index(p.a), index(p.b)} == pair && p.verdict != Verdict::separate;
        });
    };
    for (BodyPair pair : truth.colliding())
        if (!left_over(pair)) {
            row.first_miss = Sighting{frame, pair};
            break;
        }
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
