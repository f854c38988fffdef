#include "league/judge/league_truth.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;
using Meet = LeagueTruth::Meet;

/// A library may state a larger error, but then its results are judged as with this one: a share of the bodies' sizes,
/// or of the motion.
constexpr double largest_error = 0.05;

class Judge {
public:
    Judge(const LeagueTruth& truth, const league_answer& answer, const LeaguePromise& promised, double rounding)
        : truth_(truth), answer_(answer), conservative_(promised.conservative),
          doubt_((promised.precision > 0 ? promised.precision : 1e-6) * truth.size + 64 * rounding * truth.coordinate),
          stated_(std::clamp<long double>(answer.error, 0, largest_error * (truth.way > 0 ? 1 : truth.size)))
    {
    }

    LeagueVerdict of(league_question question)
    {
        switch (question) {
        case LEAGUE_MEET:
        case LEAGUE_SELF:
            judge_meeting();
            break;
        case LEAGUE_DISTANCE:
            judge_distance();
            break;
        case LEAGUE_DEPTH:
            judge_depth();
            break;
        case LEAGUE_CONTACTS:
            judge_contacts();
            break;
        case LEAGUE_CAST:
        case LEAGUE_TURN:
        case LEAGUE_RAY:
            judge_time();
            break;
        default:
            judge_pairs();
        }
        return std::move(verdict_);
    }

private:
    /// Keeps the first fault.
    void fault(LeagueFault fault, long double error, std::string expected, std::string given)
    {
        if (verdict_.fault == LeagueFault::none)
            verdict_ = {fault, double(error), std::move(expected), std::move(given)};
    }

    void judge_meeting()
    {
        const auto how = [&](const char* text, long double by) {
            return truth_.exact ? text : fmt::format("{}, by {:.3g} m", text, double(by));
        };
        const long double doubt = truth_.exact ? 0 : doubt_;
        if (truth_.meet == Meet::yes && !answer_.meet && (truth_.exact || -truth_.gap > doubt))
            fault(LeagueFault::missed, std::max(-truth_.gap, 0.0L), how("they meet", -truth_.gap), "apart");
        const bool beyond = truth_.gap > doubt_; // of exact truths the gap may be unknown
        if (truth_.meet == Meet::no && answer_.meet && (truth_.exact || conservative_ || beyond))
            fault(conservative_ && !beyond ? LeagueFault::extra : LeagueFault::invented, std::max(truth_.gap, 0.0L),
                  how("apart", truth_.gap), "they meet");
    }

    void judge_distance()
    {
        const long double given = std::max(answer_.distance, 0.0);
        const std::string expected =
            truth_.upper > 0 ? fmt::format("{:.17g} m apart", double(truth_.upper)) : "they meet";
        const std::string said = given > 0 ? fmt::format("{:.17g} m apart", double(given)) : "they meet";
        if (!(given <= truth_.upper + doubt_ + stated_)) // also a NaN
            fault(truth_.meet == Meet::yes ? LeagueFault::missed : LeagueFault::distance, given - truth_.upper,
                  expected, said);
        if (given < truth_.lower - doubt_ - stated_)
            fault(given > 0 ? LeagueFault::distance : LeagueFault::invented, truth_.lower - given, expected, said);
        if (!answer_.has_points || !(given > 0) || !truth_.off_surface) return;
        const Vector3d a(answer_.point_a), b(answer_.point_b);
        const long double off =
            std::max({truth_.off_surface(a, 0), truth_.off_surface(b, 1), std::abs((a - b).norm() - given)});
        if (!(off <= 2 * doubt_))
            fault(LeagueFault::points, off, "points on both surfaces, the distance apart",
                  fmt::format("off by {:.3g} m", double(off)));
    }

    void judge_depth()
    {
        const long double given = answer_.meet ? answer_.depth : 0;
        const std::string expected = fmt::format("{:.17g} m deep", double(truth_.upper)),
                          said = answer_.meet ? fmt::format("{:.17g} m deep", double(given)) : "apart";
        if (!answer_.meet && truth_.lower > doubt_) fault(LeagueFault::missed, truth_.lower, expected, said);
        if (!(given <= truth_.upper + doubt_ + stated_) || given < truth_.lower - doubt_ - stated_)
            fault(LeagueFault::depth, std::abs(given - truth_.upper), expected, said);
        if (!answer_.meet || !truth_.way_out || verdict_.fault != LeagueFault::none) return;
        const Vector3d normal(answer_.normal);
        const long double way = truth_.way_out(normal.normalized());
        if (!(std::abs(normal.norm() - 1) < 1e-3) || !(way <= given + 2 * doubt_))
            fault(LeagueFault::normal, way - given, "a way that parts the bodies",
                  fmt::format("they are parted after {:.3g} m along it", double(way)));
    }

    void judge_contacts()
    {
        std::vector<Vector3d> positions;
        const league_contact* deepest = nullptr;
        for (const league_contact& c : std::span(answer_.contacts, answer_.contact_count)) {
            positions.emplace_back(c.position);
            if (!deepest || !(c.depth <= deepest->depth)) deepest = &c; // a NaN is the deepest
        }
        const std::string expected = fmt::format("{:.17g} m deep", double(truth_.upper)),
                          said = deepest ? fmt::format("{} contacts, {:.17g} m deep", positions.size(), deepest->depth)
                                         : "no contact";
        const auto apart = [&] { return fmt::format("apart, by {:.3g} m", double(truth_.gap)); };
        if (!deepest && truth_.meet == Meet::yes && -truth_.gap > doubt_)
            fault(LeagueFault::missed, -truth_.gap, fmt::format("they meet, by {:.3g} m", double(-truth_.gap)), said);
        if (deepest && truth_.meet == Meet::no && truth_.gap > doubt_ && deepest->depth > doubt_ + stated_)
            fault(LeagueFault::invented, truth_.gap, apart(), said);
        if (!deepest || truth_.meet != Meet::yes) return;
        // Engines prefer the normal of a face to a slightly shorter way.
        const long double slack = 0.05L * truth_.upper + doubt_ + stated_;
        if (!(deepest->depth <= truth_.upper + slack) || deepest->depth < truth_.lower - slack)
            fault(LeagueFault::depth, std::abs(deepest->depth - truth_.upper), expected, said);
        if (truth_.tilt)
            for (const league_contact& c : std::span(answer_.contacts, answer_.contact_count)) {
                const Vector3d normal(c.normal);
                const double angle = truth_.tilt(normal.normalized());
                if (!(std::abs(normal.norm() - 1) < 1e-3) || !(angle <= 0.02))
                    fault(LeagueFault::normal, angle, "the normal of the faces",
                          fmt::format("tilted by {:.3g} rad", angle));
            }
        if (truth_.off_surface)
            for (const league_contact& c : std::span(answer_.contacts, answer_.contact_count)) {
                const Vector3d p(c.position);
                const long double off =
                    std::max(truth_.off_surface(p, 0), truth_.off_surface(p, 1)) - std::abs(c.depth);
                if (!(off <= 2 * doubt_))
                    fault(LeagueFault::points, off, "positions between the surfaces",
                          fmt::format("off by {:.3g} m", double(off)));
            }
        if (truth_.off_middle)
            if (const long double off = truth_.off_middle(positions); !(off <= 1e-3L * truth_.size))
                fault(LeagueFault::support, off, "contacts around the middle of the common area",
                      fmt::format("{} contacts leave it out by {:.3g} m", positions.size(), double(off)));
    }

    void judge_time()
    {
        const auto text = [](long double t) { return fmt::format("at {:.17g}", double(t)); };
        const std::string expected = truth_.meet == Meet::no ? "no contact" : text(truth_.upper),
                          said = answer_.meet ? text(answer_.time) : "no contact";
        if (truth_.meet == Meet::open) return;
        if (truth_.meet == Meet::no) {
            if (answer_.meet && (truth_.exact || truth_.gap > doubt_)) fault(LeagueFault::invented, 1, expected, said);
            return;
        }
        if (!answer_.meet) {
            if (truth_.exact || -truth_.gap > doubt_) fault(LeagueFault::missed, 1 - truth_.upper, expected, said);
            return;
        }
        const long double doubt = doubt_ / std::max(truth_.way, 1e-300L) + stated_, given = answer_.time;
        if (!(given <= truth_.upper + doubt) && // also a NaN
            !(truth_.deepest && given <= 1 && truth_.deepest(truth_.upper, given - stated_) <= doubt_))
            fault(LeagueFault::late, given - truth_.upper, expected, said);
        if (given < truth_.lower - doubt &&
            !(truth_.deepest && given >= 0 && -truth_.deepest(given, given + stated_) <= doubt_))
            fault(LeagueFault::early, truth_.lower - given, expected, said);
    }

    void judge_pairs()
    {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> given;
        for (std::size_t k = 0; k < answer_.pair_count; ++k)
            given.emplace_back(std::minmax(answer_.pairs[2 * k], answer_.pairs[2 * k + 1]));
        std::ranges::sort(given);
        given.erase(std::unique(given.begin(), given.end()), given.end());
        const auto lacks = [](const auto& all, const auto& pair) { return !std::ranges::binary_search(all, pair); };
        const auto missing = std::ranges::count_if(truth_.pairs, [&](const auto& pair) { return lacks(given, pair); });
        const auto more = std::ranges::count_if(given, [&](const auto& pair) { return lacks(truth_.pairs, pair); });
        const std::string expected = fmt::format("{} pairs", truth_.pairs.size()),
                          said = fmt::format("{} pairs: {} missing, {} more", given.size(), missing, more);
        if (missing) fault(LeagueFault::missed, missing, expected, said);
        if (more) fault(LeagueFault::invented, more, expected, said);
    }

    const LeagueTruth& truth_;
    const league_answer& answer_;
    bool conservative_;
    long double doubt_;  ///< metres
    long double stated_; ///< by the result: metres, or a share of the motion
    LeagueVerdict verdict_;
};

} // namespace

LeagueVerdict judge(league_question question, const LeagueTruth& truth, const league_answer& answer,
                    const LeaguePromise& promised, double rounding)
{
    return Judge(truth, answer, promised, rounding).of(question);
}

} // namespace oncollide::tools
