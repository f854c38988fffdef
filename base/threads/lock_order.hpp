#pragma once
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <shared_mutex>

#include <oncollide/base/error.hpp>
#ifdef _WIN32
#include <oncollide/base/threads/windows/waiting.hpp>
#endif

namespace oncollide {

/// The order in which a thread locks the library's mutexes: while it holds one, it may lock only mutexes of later
/// ranks, so no two threads can wait for each other. A thread never holds two mutexes of one rank.
///
/// Source: PhysicsLock of Jolt Physics asserts such an order.
enum class LockRank : std::uint8_t {
    joint_cells,    ///< Robot: the cells of check_edges()
    robot_checkers, ///< Robot: its idle checkers
    world,          ///< World: the trees of its models, which queries share
    query_workers,  ///< World: its idle workers
    chunks_in_use,  ///< ChunkResidency: no chunk is dropped while a traversal holds it
    obb_trees,      ///< PreparedTrees, ObbResidency: which OBB trees of cooked meshes there are
    prefetcher,     ///< Prefetcher: the waiting parts
    ray_tree,       ///< RayTree: growing
    obb_tree,       ///< ObbTree: growing
    terrain_tree,   ///< TerrainTree: making a part
    chunks,         ///< chunks of a mesh, map or terrain: reading
    fault_log,      ///< FaultLog
    cooked_mesh,    ///< CookedMesh: opening its file
    cooked_file,    ///< CookedFile: the faults
    rank_failures,  ///< ranks that are threads of one process: the first failure
    ranks,          ///< ranks that are threads of one process: their messages
    pool_making,    ///< the thread pool: making it
    pool,           ///< the thread pool: its tasks
};

#ifdef ONCOLLIDE_ASSERTIONS
/// One bit per rank: the mutexes that this thread holds.
inline thread_local std::uint32_t held_locks = 0;

/// A mutex that asserts the order.
template <LockRank rank, class Mutex = std::mutex>
class OrderedMutex {
public:
    void lock() { begin(), mutex_.lock(); }
    void unlock() { mutex_.unlock(), end(); }
    void lock_shared() { begin(), mutex_.lock_shared(); }
    void unlock_shared() { mutex_.unlock_shared(), end(); }

private:
    static constexpr std::uint32_t bit = 1u << static_cast<unsigned>(rank);
    static void begin()
    {
        ONCOLLIDE_ASSERT(held_locks < bit && "no mutex of this or a later LockRank is held");
        held_locks |= bit;
    }
    static void end() { held_locks &= ~bit; }

    Mutex mutex_;
};
#else
template <LockRank rank, class Mutex = std::mutex>
using OrderedMutex = Mutex;
#endif

#ifndef _WIN32
using SharedMutex = std::shared_mutex;
#endif

/// Waits with an OrderedMutex.
#if defined(_WIN32)
using OrderedCondition = Condition;
#elif defined(ONCOLLIDE_ASSERTIONS)
using OrderedCondition = std::condition_variable_any;
#else
using OrderedCondition = std::condition_variable;
#endif

} // namespace oncollide
