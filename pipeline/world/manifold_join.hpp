#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// The manifold of one pair, where it is stored.
struct StoredManifold {
    std::span<const ManifoldRegion> regions; ///< their points follow each other
    std::span<const ManifoldPoint> points;
    bool complete;

    explicit StoredManifold(const Manifold& found)
        : regions(found.regions), points(found.points), complete(found.complete)
    {
    }
    StoredManifold(const ManifoldLists& lists, std::size_t pair);
    bool is_listed() const { return !regions.empty() || !complete; } ///< in the manifolds of a frame
};

void append(ManifoldLists& lists, const StoredManifold& found);
void clear(ManifoldLists& lists);

/// Makes one list of the manifolds of many pairs. With one thread, each is copied as it is found; otherwise all are
/// copied in the end, on the threads.
class ManifoldJoin {
public:
    /// Overwrites `lists`.
    void begin(ManifoldLists& lists, int threads);
    bool at_once() const { return threads_ == 1; }
    /// Unless at_once(), the manifold must stay where it is until end().
    void add(const StoredManifold& found)
    {
        if (at_once())
            append(*lists_, found);
        else
            found_.push_back(found);
    }
    void end();
    std::size_t bytes() const;

    std::vector<ManifoldLists> parts; ///< where threads may store manifolds

private:
    ManifoldLists* lists_ = nullptr;
    int threads_ = 1;
    std::vector<StoredManifold> found_;
    std::vector<std::size_t> first_points_;
};

/// The memory of the lists.
std::size_t bytes_of(const ManifoldLists& lists);

} // namespace oncollide
