#include <oncollide/narrowphase/spheres/triangle_lists.hpp>

#include <algorithm>

namespace oncollide {

ListId TriangleLists::add(const std::uint32_t* ids, const std::uint8_t* masks, std::uint32_t count)
{
    const List list{static_cast<std::uint32_t>(ids_.size()), count};
    ids_.insert(ids_.end(), ids, ids + count);
    masks_.insert(masks_.end(), masks, masks + count);
    if (free_.empty()) {
        lists_.push_back(list);
        return static_cast<ListId>(lists_.size() - 1);
    }
    const std::uint32_t id = free_.back();
    free_.pop_back();
    lists_[id] = list;
    return static_cast<ListId>(id);
}

void TriangleLists::release(ListId list)
{
    if (list == all_triangles) return;
    List& l = lists_[static_cast<std::uint32_t>(list)];
    holes_ += l.count;
    l.count = 0;
    free_.push_back(static_cast<std::uint32_t>(list));
    if (holes_ > 4096 && 2 * holes_ > ids_.size()) pack();
}

void TriangleLists::pack()
{
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < lists_.size(); ++i)
        if (lists_[i].count) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return lists_[a].offset < lists_[b].offset; });
    std::uint32_t end = 0;
    for (std::uint32_t i : order) { // offsets ascend, so lists only move to lower offsets
        List& list = lists_[i];
        std::copy_n(ids_.begin() + list.offset, list.count, ids_.begin() + end);
        std::copy_n(masks_.begin() + list.offset, list.count, masks_.begin() + end);
        list.offset = end;
        end += list.count;
    }
    ids_.resize(end), masks_.resize(end);
    ids_.shrink_to_fit(), masks_.shrink_to_fit();
    holes_ = 0;
}

TriangleSpan TriangleLists::span(ListId list, unsigned octant) const
{
    const List& l = lists_[static_cast<std::uint32_t>(list)];
    return {ids_.data() + l.offset, masks_.data() + l.offset, l.count, octant};
}

std::size_t TriangleLists::bytes() const
{
    return ids_.capacity() * sizeof(ids_[0]) + masks_.capacity() + lists_.capacity() * sizeof(List) +
           free_.capacity() * sizeof(free_[0]);
}

} // namespace oncollide
