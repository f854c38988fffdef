// Bodies that the reference solver moves, on the contacts of a World.
#pragma once
#include <memory>

#include "peers/peers.hpp"

namespace oncollide::tools {

/// Bodies at rest fall asleep, as in an engine: they get no new poses until another body wakes them.
std::unique_ptr<PhysicsPeer> make_our_physics(std::span<const PhysicsBody> bodies, const PhysicsSettings& settings,
                                              int threads);

} // namespace oncollide::tools
