#pragma once
#include <oncollide/robots/robot_impl.hpp>

namespace oncollide {

/// The clearance of each pair: the World's, or the robot's padding where that is larger.
class Clearances {
public:
    Clearances(const Robot::Impl& robot, double of_world);

    double of_links(std::uint32_t a, std::uint32_t b) const;
    double of_body(std::uint32_t link, BodyId body) const;
    double of_world() const { return of_world_; }
    double most_of_links() const { return most_of_links_; }
    double most_of_bodies() const { return most_of_bodies_; }
    /// A pair has more than the World's.
    bool padded() const { return std::max(most_of_links_, most_of_bodies_) > of_world_; }

private:
    struct OfPair {
        std::uint32_t a, b;
        double clearance;
    };
    struct OfBody {
        BodyId body;
        std::uint32_t link; ///< no_link: all links
        double clearance;
    };

    const double of_world_;
    double self_, most_of_links_, most_of_bodies_;
    std::vector<double> of_link_; ///< with bodies that have no clearance of their own
    std::vector<OfPair> pairs_;   ///< a < b; sorted
    std::vector<OfBody> bodies_;  ///< sorted
};

} // namespace oncollide
