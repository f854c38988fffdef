// A scene of 'bench contacts' in a World.
#pragma once
#include <vector>

#include <oncollide/pipeline/world.hpp>

#include "bench/contacts/contact_scenes.hpp"
#include "peers/peers.hpp"

namespace oncollide::tools {

class OurContacts final : public ContactPeer {
public:
    OurContacts(const ContactScene& scene, int threads);
    void place(std::span<const Eigen::Isometry3d> poses) override;
    std::size_t contacts() override;
    std::size_t contacts_of(std::span<const BodyPair> pairs) override;

    World& world() { return world_; }
    const std::vector<BodyId>& ids() const { return ids_; }
    const FrameManifolds& manifolds() const { return *manifolds_; } ///< of the last contacts()
    double manifolds_ms() const { return manifolds_ms_; }           ///< part of its time

private:
    World world_;
    double margin_;
    std::vector<BodyId> ids_;
    const FrameManifolds* manifolds_ = nullptr;
    double manifolds_ms_ = 0;
    std::vector<PairOfBodies> pairs_; ///< of contacts_of()
    ManifoldLists lists_;
};

} // namespace oncollide::tools
