#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/tree/aabb_tree_kernel.hpp>

namespace oncollide {

/// Calls find(sink) and passes the pairs to take(i, j, count) in chunks that fit in the cache, so pairs that `take`
/// filters out never accumulate. Exceptions of `take` propagate.
template <class Take, class Find>
void find_in_chunks(Take take, Find find)
{
    constexpr std::uint32_t room = 2048;
    std::uint32_t i[room], j[room];
    const auto hand_on = [](PairSink& sink) {
        if (sink.count) (*static_cast<Take*>(sink.owner))(sink.i, sink.j, sink.count);
        sink.count = 0;
    };
    PairSink sink{i, j, 0, room, hand_on, &take};
    find(sink);
    hand_on(sink);
}

/// Pairs of nodes, as columns.
class NodePairs {
public:
    PairSink& sink() { return sink_; }
    void clear() { sink_.count = 0; }
    /// Overwrites the list with (k, 0) for k in [first, last).
    void assign_root(std::size_t first, std::size_t last)
    {
        ONCOLLIDE_ASSERT(first <= last);
        clear();
        while (sink_.room < last - first) grow(sink_);
        for (std::size_t k = first; k < last; ++k, ++sink_.count)
            i_[sink_.count] = static_cast<std::uint32_t>(k), j_[sink_.count] = 0;
    }
    std::size_t size() const { return static_cast<std::size_t>(sink_.count); }
    const std::uint32_t* i() const { return sink_.i; }
    const std::uint32_t* j() const { return sink_.j; }
    std::size_t bytes() const { return (i_.capacity() + j_.capacity()) * sizeof(std::uint32_t); }

private:
    static void grow(PairSink& sink)
    {
        auto& mine = *static_cast<NodePairs*>(sink.owner);
        const std::size_t room = std::max<std::size_t>(1024, 2 * mine.i_.size());
        mine.i_.resize(room), mine.j_.resize(room);
        sink.i = mine.i_.data(), sink.j = mine.j_.data(), sink.room = room;
    }

    std::vector<std::uint32_t> i_, j_;
    PairSink sink_{nullptr, nullptr, 0, 0, grow, this};
};

/// Pairs of bodies found by several threads, one list per thread.
class PairLists {
public:
    /// Clears `pairs`, which becomes the first thread's list until join().
    void begin(std::vector<BodyPair>& pairs, int threads)
    {
        if (by_thread_.size() < static_cast<std::size_t>(threads)) by_thread_.resize(static_cast<std::size_t>(threads));
        for (std::vector<BodyPair>& list : by_thread_) list.clear();
        pairs.clear();
        by_thread_[0].swap(pairs);
    }
    std::vector<BodyPair>& of(std::size_t thread)
    {
        ONCOLLIDE_ASSERT(thread < by_thread_.size());
        return by_thread_[thread];
    }
    /// Concatenates all lists, in the order of threads.
    void join(std::vector<BodyPair>& pairs)
    {
        pairs.swap(by_thread_[0]);
        for (const std::vector<BodyPair>& list : by_thread_) pairs.insert(pairs.end(), list.begin(), list.end());
    }
    std::size_t bytes() const
    {
        std::size_t sum = 0;
        for (const std::vector<BodyPair>& list : by_thread_) sum += list.capacity() * sizeof(BodyPair);
        return sum;
    }

private:
    std::vector<std::vector<BodyPair>> by_thread_;
};

/// Appends the pairs make(k), k in [0, count), for which keep(k, pair) returns true; `keep` may change the pair.
template <class Make, class Keep>
void append_kept(std::vector<BodyPair>& list, std::size_t count, Make make, Keep keep)
{
    const std::size_t before = list.size();
    if (list.capacity() < before + count) list.reserve(std::max(before + count, 2 * list.capacity()));
    list.resize(before + count);
    BodyPair* out = list.data() + before;
    for (std::size_t k = 0; k < count; ++k) {
        *out = make(k);
        out += keep(k, *out);
    }
    ONCOLLIDE_ASSERT(out <= list.data() + before + count);
    list.resize(static_cast<std::size_t>(out - list.data()));
}

} // namespace oncollide
