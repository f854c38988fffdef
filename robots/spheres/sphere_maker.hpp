#pragma once
#include <cstddef>
#include <vector>

#include <oncollide/robots/spheres/link_surface.hpp>

namespace oncollide {

/// Makes models of spheres that cover the surface of a link.
class SphereMaker {
public:
    explicit SphereMaker(const LinkSurface& surface);

    /// Few spheres that together contain every triangle, and whose points are at most `max_error` (m) from the
    /// geometry. The candidates are the largest spheres within the error around points inside the geometry; greedy set
    /// cover chooses among them. Superfluous spheres are dropped, and the others shrink.
    std::vector<CoverSphere> within(double max_error) const;

    /// A single sphere, the fewest for any error.
    CoverSphere single() const;

private:
    struct Candidate {
        Eigen::Vector3d centre;
        double depth; ///< minus the signed distance
    };
    /// Appends points inside the geometry near the middle of a patch of the surface.
    void add_candidates(const LinkSurface::Corners& patch, std::vector<Candidate>& candidates) const;

    const LinkSurface& surface_;
    std::vector<Candidate> candidates_; ///< spread over the surface
};

} // namespace oncollide
