#include "bench/broad/broad_race.hpp"
#include "cli/system.hpp"
#include "common/race.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <limits>

namespace oncollide::tools {
namespace {

constexpr double longest_ms = 20'000; // limit for the start with the first frame, and for each other frame

struct Difference {
    std::uint64_t missed = 0, extra = 0, twice = 0;
};

void sort_pairs(std::vector<BodyPair>& pairs)
{
    for (BodyPair& pair : pairs)
        if (pair.a > pair.b) std::swap(pair.a, pair.b);
    std::sort(pairs.begin(), pairs.end());
}

/// Compares two lists of pairs; sorts both.
Difference compare(std::vector<BodyPair>& right, std::vector<BodyPair>& given)
{
    Difference difference;
    sort_pairs(right), sort_pairs(given);
    const auto once = std::unique(given.begin(), given.end());
    difference.twice = std::uint64_t(given.end() - once);
    given.erase(once, given.end());
    std::vector<BodyPair> only;
    std::set_difference(right.begin(), right.end(), given.begin(), given.end(), std::back_inserter(only));
    difference.missed = only.size();
    only.clear();
    std::set_difference(given.begin(), given.end(), right.begin(), right.end(), std::back_inserter(only));
    difference.extra = only.size();
    return difference;
}

struct Entrant {
    RaceRow row;
    std::unique_ptr<BroadPeer> peer;
    std::vector<double> times; ///< ms per timed frame
    double first_ms = 0;
    std::string trouble; ///< why it is disqualified; empty: it is not
};

class BroadRace {
public:
    BroadRace(BoxScene& scene, std::uint64_t warm_up) : scene_(scene), warm_up_(warm_up), judge_(make_grid_peer())
    {
        judge_->start(frame());
    }

    void enter(const BroadContender& contender, int threads)
    {
        Entrant entrant;
        entrant.row.contender = &contender, entrant.row.threads = threads;
        entrant.first_ms = measured(entrant, [&] {
            entrant.peer = contender.make(threads);
            entrant.peer->start(frame());
        });
        entrants_.push_back(std::move(entrant));
    }

    void play_frame()
    {
        advance(scene_);
        judge_->step(frame(), right_);
        right_set_ = summarise(right_);
        take_turns(entrants_.size(), scene_.frame, [&](std::size_t k) {
            if (entrants_[k].trouble.empty()) play_frame(entrants_[k]);
        });
    }

    RaceResult result() const
    {
        RaceResult result{{}, {}, right_set_};
        for (const Entrant& entrant : entrants_) {
            if (entrant.trouble.empty()) {
                result.rows.push_back(entrant.row), result.rows.back().ms = median(entrant.times);
                if (BroadPhase* broad = entrant.peer->delimited()) {
                    const std::span<const DelimitationLevel> levels = broad->levels();
                    RaceRow& row = result.rows.back();
                    row.delimited = true, row.left = broad->bodies_left();
                    row.levels.assign(levels.begin(), levels.end());
                }
            } else
                result.left.push_back(fmt::format("{}: {}", entrant.row.contender->name, entrant.trouble));
        }
        std::sort(result.rows.begin(), result.rows.end(),
                  [](const RaceRow& a, const RaceRow& b) { return a.ms < b.ms; });
        return result;
    }

private:
    BoxFrame frame() const { return {scene_.boxes, scene_.moved, scene_.is_static}; }

    /// Milliseconds of `work`; adds the growth of memory to the entrant.
    template <class Work>
    double measured(Entrant& entrant, Work work)
    {
        trim_memory();
        const double before = double(resident_memory());
        const double ms = least_ms(1, work);
        entrant.row.bytes += std::max(0.0, double(resident_memory()) - before);
        return ms;
    }

    void play_frame(Entrant& entrant)
    {
        const auto step = [&] { entrant.peer->step(frame(), pairs_); };
        if (scene_.frame == 1) {
            pairs_.reserve(2 * right_.size()); // shared, so not counted as an entrant's memory
            entrant.first_ms += measured(entrant, step);
            if (entrant.first_ms > longest_ms)
                entrant.trouble = fmt::format("{:.0f} s for the start and the first frame", entrant.first_ms / 1e3);
        } else {
            const double ms = least_ms(1, step);
            if (scene_.frame > warm_up_) entrant.times.push_back(ms);
            if (ms > longest_ms) entrant.trouble = fmt::format("{:.0f} s for frame {}", ms / 1e3, scene_.frame);
        }
        judge(entrant);
        if (!entrant.trouble.empty()) entrant.peer.reset();
    }

    void judge(Entrant& entrant)
    {
        entrant.row.pairs = summarise(pairs_);
        if (entrant.row.pairs == right_set_) return;
        const Difference difference = compare(right_, pairs_);
        entrant.row.missed = std::max(entrant.row.missed, difference.missed);
        entrant.row.extra = std::max(entrant.row.extra, difference.extra);
        const bool wrong = difference.missed || difference.twice;
        if (wrong && entrant.row.contender->group != Group::oncollide)
            entrant.trouble = fmt::format("wrong in frame {}: {} of {} pairs missed, {} reported twice", scene_.frame,
                                          difference.missed, right_.size(), difference.twice);
    }

    BoxScene& scene_;
    std::uint64_t warm_up_;
    std::unique_ptr<BroadPeer> judge_;
    std::vector<Entrant> entrants_;
    std::vector<BodyPair> right_, pairs_; ///< pairs of this frame: the correct ones and the entrant's
    PairSet right_set_;
};

void set_ratios(std::vector<RaceRow>& rows)
{
    for (RaceRow& row : rows) {
        double best = std::numeric_limits<double>::infinity();
        for (const RaceRow& peer : rows)
            if (peer.contender->group == Group::debian && peer.threads <= row.threads) best = std::min(best, peer.ms);
        if (best < std::numeric_limits<double>::infinity() && row.ms > 0) row.ratio = best / row.ms;
    }
}

} // namespace

RaceResult race(BoxScene& scene, const std::vector<BroadContender>& contenders, const std::vector<int>& threads,
                std::uint64_t frames, std::uint64_t warm_up)
{
    BroadRace race(scene, warm_up);
    std::vector<std::string> left;
    for (const BroadContender& contender : contenders) {
        if (scene.boxes.size() > contender.most) {
            left.push_back(fmt::format("{}: supports at most {} boxes", contender.name, grouped(contender.most)));
            continue;
        }
        if (!contender.threaded)
            race.enter(contender, 1);
        else
            for (int count : threads) race.enter(contender, count);
    }
    while (scene.frame < frames) race.play_frame();
    RaceResult result = race.result();
    result.left.insert(result.left.begin(), left.begin(), left.end());
    set_ratios(result.rows);
    return result;
}

} // namespace oncollide::tools
