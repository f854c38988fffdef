#pragma once
#include <memory>
#include <span>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::oracle {

/// The squared distance of two triangles as a fraction of integers, 0 if they meet: exact for all doubles. Triangles
/// may be segments or points. Shares no code with the library. Cost: 20 to 60 microseconds; milliseconds if magnitudes
/// are far apart.
class ExactDistance {
public:
    ExactDistance(const TrianglePoints& a, const TrianglePoints& b);
    /// The segments go from a[0] to a[1] and from b[0] to b[1].
    using SegmentPoints = std::array<Eigen::Vector3d, 2>;
    ExactDistance(const SegmentPoints& a, const SegmentPoints& b);
    ~ExactDistance();
    ExactDistance(ExactDistance&&) noexcept;
    ExactDistance& operator=(ExactDistance&&) noexcept;

    /// The sign of the distance minus `length`, which is finite and >= 0.
    int compare(double length) const;
    long double value() const; ///< rounded
    bool operator<(const ExactDistance& other) const;

private:
    struct Square;
    std::unique_ptr<Square> square_;
};

/// The distance of a triangle, a segment or a point from the nearest of `others`, which must not be empty.
ExactDistance least_distance(const TrianglePoints& triangle, std::span<const TrianglePoints> others);

} // namespace oncollide::oracle
