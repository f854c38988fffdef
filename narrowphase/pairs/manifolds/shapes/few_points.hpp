#pragma once
#include <array>
#include <span>

#include <oncollide/narrowphase/pairs/manifolds/shapes/clipped_face.hpp>

namespace oncollide {

/// The points of a region of two shapes, and the choice of a few.
class FewPoints {
public:
    struct Candidate {
        Eigen::Vector3d on_a, on_b;
        double depth, off;
        FeatureBits of_a, of_b;
    };
    void add(const Candidate& c)
    {
        if (count_ < all_.size()) all_[count_++] = c;
    }
    void clear() { count_ = 0; }
    bool empty() const { return count_ == 0; }
    std::uint32_t count() const { return count_; }
    double deepest() const;
    std::span<Candidate> from(std::uint32_t first) { return std::span(all_).subspan(first, count_ - first); }
    std::span<const Candidate> chosen() const { return std::span(all_).first(count_); }

    /// Drops points of less depth, but not the deepest.
    void drop_shallow(double least);
    /// Drops points that may be farther than `off` (metres) from the surfaces, if others are not.
    void drop_loose(double off);
    /// Keeps at most this many: the deepest, the farthest from it, the corner of the largest triangle, then always the
    /// point that adds the most area. Points at one place count as one. @param place  metres: points less
    /// apart are at one place
    void choose(const Eigen::Vector3d& normal, double place, std::uint32_t most);

private:
    std::uint32_t count_ = 0;
    std::array<Candidate, ClippedFace::most + 2> all_;
};

} // namespace oncollide
