#pragma once
#include <cstddef>
#include <vector>

namespace oncollide {

/// The boxes that a walk still has to visit. The boxes of each node are visited in the order of their entries, before
/// the boxes of earlier nodes. Box has a member `entry`.
template <class Box>
class NearestBoxes {
public:
    void clear() { waiting_ = 0; }
    bool empty() const { return waiting_ == 0; }
    /// The boxes that are added next, at most eight, are of another node.
    void begin_node()
    {
        first_ = waiting_;
        if (boxes_.size() < first_ + 8) boxes_.resize(2 * boxes_.size());
    }
    void add(const Box& box)
    {
        std::size_t place = waiting_++;
        for (; place > first_ && boxes_[place - 1].entry < box.entry; --place) boxes_[place] = boxes_[place - 1];
        boxes_[place] = box;
    }
    /// Removes the next box. There must be one.
    const Box& take() { return boxes_[--waiting_]; }

private:
    std::vector<Box> boxes_ = std::vector<Box>(64); ///< the first `waiting_` of them, the next one last
    std::size_t waiting_ = 0, first_ = 0;
};

} // namespace oncollide
