// Ranks as threads of this process.
#include <exception>
#include <map>
#include <queue>
#include <thread>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/runs/ranks/ranks.hpp>

namespace oncollide {

namespace {

/// State shared by all ranks. A collective call writes, meets, reads and meets again, so data that others still read
/// are not overwritten.
struct Shared {
    explicit Shared(int ranks) : size(ranks), slots(std::size_t(ranks), nullptr) {}

    /// Waits until all ranks have arrived. Throws if a rank has failed.
    void meet()
    {
        std::unique_lock lock(mutex);
        const std::uint64_t now = meetings;
        if (++here == size) {
            here = 0, ++meetings;
            wake.notify_all();
        }
        wake.wait(lock, [&] { return meetings != now || broken; });
        if (meetings == now) throw Error(ErrorKind::internal, "another rank has failed");
    }
    void leave_broken()
    {
        const std::lock_guard lock(mutex);
        broken = true;
        wake.notify_all();
    }

    const int size;
    OrderedMutex<LockRank::ranks> mutex;
    OrderedCondition wake;
    int here = 0;
    std::uint64_t meetings = 0;
    bool broken = false;
    std::vector<const void*> slots; ///< by rank: data shown to the others
    std::map<std::pair<int, int>, std::queue<std::uint64_t>> sent;
};

class ThreadRank final : public Ranks {
public:
    ThreadRank(Shared& shared, int rank) : shared_(shared), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return shared_.size; }

    void exchange(std::span<const Bytes> out, std::vector<Bytes>& in) override
    {
        in.resize(std::size_t(size()));
        look(out.data(), [&](int from, const Bytes* theirs) { in[std::size_t(from)] = theirs[rank_]; });
    }
    void gather(const Bytes& mine, std::vector<Bytes>& all) override
    {
        all.resize(std::size_t(size()));
        look(&mine, [&](int from, const Bytes* theirs) { all[std::size_t(from)] = *theirs; });
    }
    void sum(std::span<std::uint64_t> numbers) override
    {
        std::vector<std::uint64_t> sums(numbers.size());
        look(numbers.data(), [&](int, const std::uint64_t* theirs) {
            for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += theirs[k];
        });
        std::copy(sums.begin(), sums.end(), numbers.begin());
    }
    void most(std::span<double> numbers) override
    {
        std::vector<double> most(numbers.begin(), numbers.end());
        look(numbers.data(), [&](int, const double* theirs) {
            for (std::size_t k = 0; k < most.size(); ++k) most[k] = std::max(most[k], theirs[k]);
        });
        std::copy(most.begin(), most.end(), numbers.begin());
    }
    std::uint64_t before(std::uint64_t number) override
    {
        std::uint64_t sum = 0;
        look(&number, [&](int from, const std::uint64_t* theirs) { sum += from < rank_ ? *theirs : 0; });
        return sum;
    }
    void send(int to, std::uint64_t number) override
    {
        const std::lock_guard lock(shared_.mutex);
        shared_.sent[{rank_, to}].push(number);
        shared_.wake.notify_all();
    }
    std::uint64_t receive(int from) override
    {
        std::unique_lock lock(shared_.mutex);
        auto& queue = shared_.sent[{from, rank_}];
        shared_.wake.wait(lock, [&] { return !queue.empty() || shared_.broken; });
        if (queue.empty()) throw Error(ErrorKind::internal, "another rank has failed");
        const std::uint64_t number = queue.front();
        queue.pop();
        return number;
    }
    void abort(int) override {}

private:
    template <class Shown, class Take>
    void look(const Shown* shown, Take take)
    {
        shared_.slots[std::size_t(rank_)] = shown;
        shared_.meet();
        for (int from = 0; from < size(); ++from)
            take(from, static_cast<const Shown*>(shared_.slots[std::size_t(from)]));
        shared_.meet();
    }

    Shared& shared_;
    int rank_;
};

} // namespace

void run_ranks_on_threads(int size, const std::function<void(Ranks&)>& work)
{
    Shared shared(size);
    OrderedMutex<LockRank::rank_failures> mutex;
    std::exception_ptr first;
    const auto play = [&](int rank) {
        try {
            ThreadRank ranks(shared, rank);
            work(ranks);
        } catch (...) {
            {
                const std::lock_guard lock(mutex);
                if (!first) first = std::current_exception();
            }
            shared.leave_broken();
        }
    };
    {
        std::vector<std::jthread> others;
        for (int rank = 1; rank < size; ++rank) others.emplace_back(play, rank);
        play(0);
    }
    if (first) std::rethrow_exception(first);
}

} // namespace oncollide
