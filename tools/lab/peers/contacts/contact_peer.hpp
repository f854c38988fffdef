#pragma once
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/geometry.hpp>

#include "peers/common/contender.hpp"

// Contenders of the benchmark of contacts. One file per library; each adds its contenders to the list.
namespace oncollide::tools {

/// A body of a benchmark: a mesh or a box.
struct ContactPeerBody {
    const Geometry* geometry;
    bool is_static;
};

/// Finds contacts for a solver.
class ContactPeer {
public:
    virtual ~ContactPeer() = default;
    /// Finds the contacts of all pairs of which a body moves, at these poses of the bodies. Returns their number.
    virtual std::size_t contacts(std::span<const Eigen::Isometry3d> poses) = 0;
};

using ContactContender = Contender<ContactPeer, std::span<const ContactPeerBody>>;

using ContactContenders = ContenderList<ContactContender>;

/// The contenders of other libraries in this build.
ContactContenders contact_contenders();

void add_contact_fcl(std::vector<ContactContender>& all);
void add_contact_bullet(std::vector<ContactContender>& all);
void add_contact_ode(std::vector<ContactContender>& all);

} // namespace oncollide::tools
