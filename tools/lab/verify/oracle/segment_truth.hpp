#pragma once
#include <memory>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::oracle {

/// The fraction of a segment at its first point in triangles and solid boxes, in rational arithmetic, which shares
/// nothing with the library's.
class SegmentTruth {
public:
    SegmentTruth();
    ~SegmentTruth();
    SegmentTruth(SegmentTruth&&) noexcept;
    void add(const Segment& segment, const TrianglePoints& triangle);
    void add(const Segment& segment, const Aabb& box);
    void add_start(); ///< the segment begins in something solid

    bool met() const { return first_ != nullptr; }
    /// The fraction exists, and is in the bounds.
    bool within(double lower, double upper) const;
    /// Both exist and are equal.
    bool equals(const SegmentTruth& other) const;

private:
    struct Fraction;
    void take(const Fraction& first);
    std::unique_ptr<Fraction> first_;
};

} // namespace oncollide::oracle
