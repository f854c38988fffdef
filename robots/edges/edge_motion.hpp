#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/robots/robot_impl.hpp>

namespace oncollide {

/// A pair of parts, or a part and a body, in a window of an edge.
struct EdgeItem {
    double begin, end;
    std::uint32_t a, b; ///< parts; b of a body: no_part
    BodyId body;
    std::uint32_t seen_from; ///< the link from which motions are bounded
    std::uint32_t box = 0;   ///< box of the body: number in EdgeCull
    double middle() const { return 0.5 * (begin + end); }
};
constexpr std::uint32_t no_part = 0xffffffffu;

/// The motion of both sides of an item in its window; a body is at rest.
struct EdgeWays {
    BallTravel a, b;
    double turned() const { return a.turned + b.turned; }
};

/// Parts that no joint moves against each other on an edge.
struct RigidParts {
    std::uint32_t link; ///< the highest link of the parts
    CoverSphere ball;   ///< around them, in the frame of `link`, stretched by Impl::stretch()
    std::vector<std::uint32_t> parts;
};

/// The motion of a robot between two configurations.
class EdgeMotion {
public:
    /// The links at a share of the edge.
    struct Placed {
        double share = -1;
        std::vector<Eigen::Isometry3d> links;
    };

    explicit EdgeMotion(const Robot::Impl& robot);

    /// The numbers stay the caller's. Finds the rigid parts.
    void start(const double* from, const double* to);

    const double* from() const { return from_; }
    const double* to() const { return to_; }
    const std::vector<RigidParts>& rigid() const { return rigid_; }
    std::uint32_t rigid_of(std::uint32_t part) const { return rigid_of_[part]; } ///< index in rigid()

    /// The links at a share. Valid until start() if the share is a multiple of 1 / 128, else until the call after the
    /// next.
    const Placed& at(double share);
    /// The links at middle(), which the calls below take for the middle of the item's window. Valid until the next
    /// call.
    const Eigen::Isometry3d* place(double share);
    const Placed& middle() const { return *middle_; }

    EdgeWays ways_of(const EdgeItem& item) const;
    /// The motion of a ball in the frame of a link, seen from the item's link.
    BallTravel travel(const EdgeItem& item, const CoverSphere& ball, std::uint32_t link) const;
    double reach(const EdgeWays& ways) const { return (ways.a.moved + ways.b.moved) * robot_.stretch(); }

private:
    bool is_on_grid(double share) const;
    void place(Placed& placed, double share);

    const Robot::Impl& robot_;
    std::vector<double> numbers_;
    std::vector<Placed> grid_, others_; ///< at multiples of 1 / 128; the last other ones
    std::size_t next_ = 0;              ///< index in others_ of the entry that a new share replaces
    Placed own_;                        ///< poses at middle_, if that is not on the grid
    const Placed* middle_ = nullptr;
    const double *from_ = nullptr, *to_ = nullptr;
    std::vector<std::uint32_t> highest_, rigid_of_;
    std::vector<RigidParts> rigid_;
    std::vector<CoverSphere> balls_;
};

} // namespace oncollide
