#pragma once
#include <vector>

#include <oncollide/robots/kinematics.hpp>
#include <oncollide/robots/robot.hpp>
#include <oncollide/robots/spheres/cover.hpp>

namespace oncollide {

/// The bounding spheres of a part, to rule out pairs: the first contains the part, as do the others together.
struct PartSpheres {
    std::uint32_t first, count; ///< in Impl::spheres, without the whole one
    CoverSphere whole;
};

struct Robot::Impl {
    /// A geometry of a link, or an attached object.
    struct Part {
        std::uint32_t link;
        ModelId model;
        Eigen::Isometry3d pose; ///< in the link's frame
        PartSpheres cover;
        std::vector<std::uint32_t> touching; ///< links that are not tested with this part
    };
    struct PartPair {
        std::uint32_t a, b;
        std::uint32_t near = 0; ///< of the sampled configurations, those in which bounding spheres overlap
    };

    Impl(World& world, RobotDescription given, const Eigen::Isometry3d& base_pose);

    void add_part(std::uint32_t link, ModelId model, const Eigen::Isometry3d& pose, std::vector<CoverSphere> spheres,
                  std::span<const std::uint32_t> touching);
    /// Lists the pairs of parts that are tested, those most often near each other first.
    void find_pairs();
    /// Throws Error{usage} if the World is not this robot's.
    void check_world(const World& world) const;
    void check_width(std::size_t numbers) const;
    Eigen::Isometry3d pose_of(const Part& part, const Eigen::Isometry3d* links) const
    {
        return links[part.link] * part.pose;
    }

    RobotDescription description;
    Kinematics tree;
    Eigen::Isometry3d base;
    std::vector<Part> parts;          ///< by links, then attached objects
    std::vector<CoverSphere> spheres; ///< of all parts, in the frames of their links
    std::size_t attached_from = 0;
    std::size_t spheres_of_links = 0;
    std::vector<PartPair> pairs;
    std::vector<BodyId> bodies;
    ModelId any_model{}; ///< tells the World
};

/// Whether bounding spheres of two parts come closer than the clearance.
class SphereCull {
public:
    SphereCull(const Robot::Impl& robot, double clearance);
    /// Places the spheres at a configuration.
    void place(const Eigen::Isometry3d* links);
    /// False: the parts are certainly farther apart than the clearance.
    bool near(std::uint32_t a, std::uint32_t b);

private:
    struct Placed {
        double x, y, z, radius;
    };
    bool meet(const Placed& a, const Placed& b) const;
    const Placed* spheres_of(std::uint32_t part);
    Placed placed(const CoverSphere& sphere, std::uint32_t link) const;

    const Robot::Impl& robot_;
    const double clearance_;
    const Eigen::Isometry3d* links_ = nullptr;
    std::vector<Placed> whole_, spheres_;
    std::vector<std::uint8_t> placed_;
};

} // namespace oncollide
