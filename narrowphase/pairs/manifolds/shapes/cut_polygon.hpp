#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace oncollide {

/// A convex polygon that lines cut one after the other. Its own edges have numbers from 0 on; the cut by line k is edge
/// -1 - k. More than `room` corners, which only rounding can give, are left out.
template <std::uint32_t room>
class CutPolygon {
public:
    struct Corner {
        Eigen::Vector3d at;
        int before, after; ///< the edges that meet here
    };
    void add(const Corner& corner) { lists_[now_][count_++] = corner; }
    std::span<const Corner> corners() const { return std::span(lists_[now_]).first(count_); }

    /// Cuts off the part above a line. @param above  the height of a point over it
    /// @param slack  a corner may be as high
    template <class Height>
    void cut(int line, double slack, Height above)
    {
        const auto& from = lists_[now_];
        std::array<double, room> height;
        bool any = false;
        for (std::uint32_t i = 0; i < count_; ++i) height[i] = above(from[i].at), any |= height[i] > slack;
        if (!any) return;
        auto& to = lists_[1 - now_];
        std::uint32_t kept = 0;
        const auto keep = [&](const Corner& corner) {
            if (kept < room) to[kept++] = corner;
        };
        for (std::uint32_t i = 0; i < count_; ++i) {
            const std::uint32_t j = i + 1 < count_ ? i + 1 : 0;
            const bool in = height[i] <= slack, next_in = height[j] <= slack;
            if (in) keep(from[i]);
            if (in == next_in) continue;
            const double t = std::clamp(height[i] / (height[i] - height[j]), 0.0, 1.0);
            const int cut = -1 - line;
            keep({from[i].at + t * (from[j].at - from[i].at), in ? from[i].after : cut, in ? cut : from[i].after});
        }
        now_ = 1 - now_, count_ = kept;
    }

private:
    std::array<Corner, room> lists_[2];
    std::uint32_t count_ = 0;
    int now_ = 0;
};

} // namespace oncollide
