#pragma once
#include <array>

#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_face.hpp>

namespace oncollide {

/// The part of a face that lies over another, flat face, seen along a direction.
struct ClippedFace {
    static constexpr std::uint32_t most = 2 * ContactFace::most;
    struct Corner {
        Eigen::Vector3d at;
        FeatureBits of_face, of_flat; ///< the features of both that meet here
    };
    std::uint32_t count;
    std::array<Corner, most> corner;

    /// @param face  a point, a segment or a polygon
    /// @param flat  a polygon
    /// @param along  unit, on the flat face's outer side: the direction in which one is seen over the other
    /// @param off    metres: a corner may lie this far outside of the polygon
    void find(const ContactFace& face, const ContactFace& flat, const Eigen::Vector3d& along, double off);

private:
    void clip_segment(const ContactFace& face, const ContactFace& flat);
    void clip_polygon(const ContactFace& face, const ContactFace& flat);

    Eigen::Vector3d along_;
    double off_;
};

} // namespace oncollide
