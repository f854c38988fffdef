#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/robots/cover.hpp>
#include <oncollide/robots/robot.hpp>

namespace oncollide {

/// Upper bounds for all points of a ball that moves with a link.
struct BallTravel {
    double moved = 0;  ///< metres from the middle of the motion
    double turned = 0; ///< rad between both ends
    double speed = 0;  ///< metres per part
    double bend = 0;   ///< second derivative of the position: metres per part squared
    bool helix = true; ///< at most one joint moves: all points move along helices, or straight

    /// How far points leave the rigid motion between the poses at both ends: MotionPath::screw for a helix, else
    /// MotionPath::linear.
    /// @param arm  upper bound on the distance of the points from the origin of that motion
    double off(double arm) const;
    /// How far points leave the straight lines between their places at both ends.
    double sagitta() const { return 0.125 * bend * (1 + 1e-12); }
};

/// The joints of a robot in an order in which each follows the joints above it.
class Kinematics {
public:
    /// @param robot  a description without a fault (description_fault.hpp)
    explicit Kinematics(const RobotDescription& robot);

    const std::vector<std::string>& names() const { return names_; }
    std::size_t width() const { return names_.size(); }
    std::uint32_t root() const { return root_; }
    /// The joint's first number in a configuration; -1: it has none of its own.
    int first_number(std::uint32_t joint) const { return first_[joint]; }
    /// `numbers` must be finite, quaternions unit.
    void link_poses(const double* numbers, const Eigen::Isometry3d& base, Eigen::Isometry3d* poses) const;

    /// How a number of a configuration moves a link: points p of it by linear + angular x (p - origin) per unit.
    struct Twist {
        Eigen::Vector3d linear, angular, origin; ///< in the world
    };
    /// Calls visit(number, twist) for each number that moves the link, from the link up; several times for one that
    /// several joints mimic.
    /// @param poses  the poses of all links at these numbers
    template <class Visit>
    void each_twist(const double* numbers, const Eigen::Isometry3d* poses, std::uint32_t link, Visit visit) const;

    /// The configuration at a share of an edge: numbers change in proportion, quaternions along the shorter arc.
    void between(const double* from, const double* to, double share, double* numbers) const;
    /// Sets for each link the highest link that does not move against it on an edge.
    void rigid_links(const double* from, const double* to, std::vector<std::uint32_t>& highest) const;
    /// How a ball that is fixed to a link moves, seen from another link, in a part of an edge.
    /// @param half   half of the part, as a share of the edge
    /// @param ball   the ball in the frame of `link`
    /// @param poses  the poses of all links, in the middle of the part
    BallTravel travel(const double* from, const double* to, double half, const Eigen::Isometry3d* poses,
                      const CoverSphere& ball, std::uint32_t link, std::uint32_t seen_from) const;
    /// The links on the way from link a to link b, both included.
    std::vector<std::uint32_t> links_between(std::uint32_t a, std::uint32_t b) const;
    /// The way from a link to another one.
    struct Way {
        std::uint32_t links;  ///< both included
        std::uint32_t middle; ///< the link in the middle
    };
    /// Sets the ways from one link to each other link. Cost: as many steps as there are links.
    void ways_from(std::uint32_t link, std::vector<Way>& ways) const;

    /// A number on which the pose of one link, seen from another, depends.
    struct Acting {
        std::uint32_t number;
        bool turns; ///< its joints rotate by plus or minus the number, so a full turn changes nothing
    };
    /// Sets the numbers that act between the two links, in ascending order. Returns false if a planar or a floating
    /// joint is between them.
    bool numbers_between(std::uint32_t a, std::uint32_t b, std::vector<Acting>& numbers) const;

private:
    /// The pose of a child in its parent's frame, as a function of the joint's value v: a rotation joint's linear part
    /// is constant + sin(v) * by_sine + cos(v) * by_cosine.
    struct Step {
        std::uint32_t parent, child;
        JointKind kind;
        std::uint32_t number, width; ///< range of the joint's numbers; width 0: fixed
        double multiplier, offset;
        Eigen::Matrix3d constant, by_sine, by_cosine;
        Eigen::Vector3d translation, along; ///< along: per unit of a prismatic joint
        Eigen::Isometry3d origin;
        Eigen::Vector3d axis;
    };
    /// The numbers' twists of a planar or a floating joint, in the frame of its origin.
    static std::span<const Twist> twists_of(const Step& step, const double* numbers, std::array<Twist, 7>& twists);
    Step step_of(const RobotDescription& robot, std::uint32_t joint) const;
    std::uint32_t parent(std::uint32_t link) const { return steps_[step_to_[link]].parent; }
    /// The lowest link that is above both, or one of them.
    std::uint32_t common(std::uint32_t a, std::uint32_t b) const;

    std::vector<std::string> names_;
    std::vector<int> first_;
    std::vector<Step> steps_;
    std::vector<std::uint32_t> step_to_;            ///< by link: the step that leads to it; the root has none
    std::vector<std::vector<std::uint32_t>> below_; ///< by link: its children
    std::vector<std::uint32_t> depth_;              ///< by link: steps from the root
    std::uint32_t root_ = 0;
};

template <class Visit>
void Kinematics::each_twist(const double* numbers, const Eigen::Isometry3d* poses, std::uint32_t link,
                            Visit visit) const
{
    for (; link != root_; link = parent(link)) {
        const Step& step = steps_[step_to_[link]];
        const Eigen::Vector3d origin = poses[link].translation();
        const auto zero = Eigen::Vector3d::Zero();
        switch (step.kind) {
        case JointKind::fixed:
            break;
        case JointKind::prismatic:
            if (step.width)
                visit(step.number, Twist{step.multiplier * (poses[step.parent].linear() * step.along), zero, origin});
            break;
        case JointKind::revolute:
        case JointKind::continuous:
            if (step.width)
                visit(step.number, Twist{zero, step.multiplier * (poses[link].linear() * step.axis), origin});
            break;
        case JointKind::planar:
        case JointKind::floating: {
            const Eigen::Matrix3d frame = poses[step.parent].linear() * step.origin.linear();
            std::array<Twist, 7> twists;
            std::uint32_t number = step.number;
            for (const Twist& twist : twists_of(step, numbers, twists))
                visit(number++, Twist{frame * twist.linear, frame * twist.angular, origin});
            break;
        }
        }
    }
}

} // namespace oncollide
