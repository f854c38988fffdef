#include "bench/narrow_race.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include <oncollide/base/random.hpp>
#include <oncollide/scenes/motion.hpp>

#include "bench/bench.hpp"
#include "cli/progress.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double long_us = 5'000; // what a query may take in all before it is repeated no more

double microseconds_since(Clock::time_point from)
{
    return std::chrono::duration<double, std::micro>(Clock::now() - from).count();
}

/// An answer to any of the asks.
struct Answer {
    bool colliding = false;
    std::vector<TrianglePair> pairs;
    double distance = 0;
};

void give(NarrowPeer& peer, Ask ask, const Eigen::Isometry3d& pose, Answer& answer)
{
    if (ask == Ask::boolean)
        answer.colliding = peer.collides(pose);
    else if (ask == Ask::all)
        peer.all_pairs(pose, answer.pairs);
    else
        answer.distance = peer.distance(pose);
}

/// Independent of the order of pairs.
std::uint64_t hash_of(Ask ask, const Answer& answer)
{
    if (ask == Ask::boolean) return splitmix(answer.colliding);
    if (ask == Ask::distance) return splitmix(std::bit_cast<std::uint64_t>(answer.distance));
    std::uint64_t sum = 0;
    for (const TrianglePair& pair : answer.pairs) sum += splitmix(std::uint64_t{pair.a} << 32 | pair.b);
    return splitmix(sum);
}

std::uint64_t not_in(const std::vector<TrianglePair>& these, const std::vector<TrianglePair>& those)
{
    std::uint64_t count = 0;
    for (const TrianglePair& pair : these) count += !std::binary_search(those.begin(), those.end(), pair);
    return count;
}

struct Entrant {
    NarrowRow row;
    std::unique_ptr<NarrowPeer> peer;
};

class Race {
public:
    Race(const Mesh& a, const Mesh& b, const NarrowCourse& workload, const NarrowTruth& truth,
         const std::vector<Ask>& asks, int repeats)
        : a_(a), b_(b), course_(workload), truth_(truth), asks_(asks), repeats_(repeats)
    {
    }

    /// Builds the contender and lets it meet every pose once.
    void enter(const NarrowContender& contender)
    {
        Entrant entrant;
        entrant.row.contender = &contender;
        for (Ask ask : asks_)
            if (answers(contender, ask)) entrant.row.asks[std::size_t(ask)] = empty_result(ask);
        trim_memory();
        const double before = double(resident_memory());
        Clock::time_point from = Clock::now();
        entrant.peer = contender.make(a_, b_);
        entrant.row.build_ms = 1e-3 * microseconds_since(from);
        from = Clock::now();
        Progress progress("warming up " + contender.name, course_.poses.size());
        for (const NarrowPose& pose : course_.poses) {
            for (Ask ask : asks_)
                if (answers(contender, ask)) give(*entrant.peer, ask, pose.known.b, answer_);
            progress.step();
        }
        entrant.row.warm_up_ms = 1e-3 * microseconds_since(from);
        trim_memory();
        entrant.row.bytes = std::max(0.0, double(resident_memory()) - before);
        entrants_.push_back(std::move(entrant));
    }

    std::vector<NarrowRow> run()
    {
        Progress progress("measuring", course_.poses.size());
        for (std::size_t pose = 0; pose < course_.poses.size(); ++pose, progress.step())
            for (Ask ask : asks_)
                for (std::size_t k = 0; k < entrants_.size(); ++k)
                    if (Entrant& entrant = entrants_[(k + pose) % entrants_.size()];
                        answers(*entrant.row.contender, ask))
                        measure(entrant, ask, pose);
        std::vector<NarrowRow> rows;
        for (Entrant& entrant : entrants_) rows.push_back(std::move(entrant.row));
        return rows;
    }

private:
    AskResult empty_result(Ask ask) const
    {
        const std::size_t poses = course_.poses.size();
        AskResult result;
        result.us.resize(poses), result.hashes.resize(poses);
        if (ask == Ask::distance)
            result.errors.resize(poses);
        else
            result.missed.resize(poses), result.extra.resize(poses);
        return result;
    }

    void measure(Entrant& entrant, Ask ask, std::size_t pose)
    {
        double least = 1e300, sum = 0;
        for (int repeat = 0; repeat < repeats_ && sum < long_us; ++repeat) {
            const Clock::time_point from = Clock::now();
            give(*entrant.peer, ask, course_.poses[pose].known.b, answer_);
            const double us = microseconds_since(from);
            least = std::min(least, us), sum += us;
        }
        AskResult& result = *entrant.row.asks[std::size_t(ask)];
        result.us[pose] = least;
        result.hashes[pose] = hash_of(ask, answer_);
        compare(ask, pose, result);
    }

    void compare(Ask ask, std::size_t pose, AskResult& result)
    {
        if (ask == Ask::boolean) {
            result.missed[pose] = !answer_.colliding && truth_.colliding[pose];
            result.extra[pose] = answer_.colliding && !truth_.colliding[pose];
        } else if (ask == Ask::all) {
            std::vector<TrianglePair>& given = answer_.pairs;
            std::sort(given.begin(), given.end());
            const auto once = std::unique(given.begin(), given.end());
            const std::uint64_t twice = std::uint64_t(given.end() - once);
            given.erase(once, given.end());
            result.missed[pose] = not_in(truth_.pairs[pose], given);
            result.extra[pose] = not_in(given, truth_.pairs[pose]) + twice;
        } else {
            result.errors[pose] = std::abs(answer_.distance - truth_.distances[pose]);
        }
    }

    const Mesh &a_, &b_;
    const NarrowCourse& course_;
    const NarrowTruth& truth_;
    const std::vector<Ask>& asks_;
    int repeats_;
    std::vector<Entrant> entrants_;
    Answer answer_;
};

} // namespace

bool answers(const NarrowContender& contender, Ask ask)
{
    return ask == Ask::boolean || (ask == Ask::all ? contender.answers_all : contender.answers_distance);
}

std::vector<NarrowRow> race(const Mesh& a, const Mesh& b, const NarrowCourse& workload, const NarrowTruth& truth,
                            const std::vector<NarrowContender>& contenders, const std::vector<Ask>& asks, int repeats)
{
    Race race(a, b, workload, truth, asks, repeats);
    for (const NarrowContender& contender : contenders)
        if (std::any_of(asks.begin(), asks.end(), [&](Ask ask) { return answers(contender, ask); }))
            race.enter(contender);
    return race.run();
}

} // namespace oncollide::tools
