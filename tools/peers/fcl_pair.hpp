#pragma once
#include <cstdint>
#include <vector>

#include <fcl/fcl.h>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// FCL's trees of `Volume` over two meshes, of which the second is moved. No contacts: FCL is fastest so.
template <class Volume>
class FclPair {
public:
    FclPair(const Mesh& a, const Mesh& b) { fill(a_, a), fill(b_, b); }

    /// The number of intersecting triangle pairs, counted up to `most`.
    std::size_t collide(const Eigen::Isometry3d& b, std::size_t most = 1) const { return ask(b, most).numContacts(); }

    /// Calls `take` with the numbers of every two triangles that intersect.
    template <class Take>
    void all_pairs(const Eigen::Isometry3d& b, Take take) const
    {
        const fcl::CollisionResultd result = ask(b, 1'000'000'000);
        for (std::size_t k = 0; k < result.numContacts(); ++k) {
            const fcl::Contactd& contact = result.getContact(k);
            take(std::uint32_t(contact.b1), std::uint32_t(contact.b2));
        }
    }

    /// Of the surfaces, 0 when they touch. Only trees with swept spheres (RSS, OBBRSS) answer this.
    double distance(const Eigen::Isometry3d& b) const
    {
        const fcl::DistanceRequestd request;
        fcl::DistanceResultd result;
        const double distance = fcl::distance(&a_, Eigen::Isometry3d::Identity(), &b_, b, request, result);
        return distance > 0 ? distance : 0;
    }

private:
    static void fill(fcl::BVHModel<Volume>& model, const Mesh& mesh)
    {
        std::vector<fcl::Triangle> triangles;
        triangles.reserve(mesh.triangles.size());
        for (const Triangle& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
        model.beginModel(int(triangles.size()), int(mesh.vertices.size()));
        model.addSubModel(mesh.vertices, triangles);
        model.endModel();
    }

    fcl::CollisionResultd ask(const Eigen::Isometry3d& b, std::size_t most) const
    {
        const fcl::CollisionRequestd request(most, false);
        fcl::CollisionResultd result;
        fcl::collide(&a_, Eigen::Isometry3d::Identity(), &b_, b, request, result);
        return result;
    }

    fcl::BVHModel<Volume> a_, b_;
};

} // namespace oncollide::tools
