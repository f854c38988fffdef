// How 'bench contacts' compares libraries at the same poses.
#pragma once
#include <optional>

#include "bench/contacts/contact_scenes.hpp"
#include "peers/peers.hpp"

namespace oncollide::tools {

/// One line of the table: means over the steps, or over the pairs of a scene whose pairs are alone.
struct ContactRow {
    std::string name{};
    double ms = 0, first_ms = 0; ///< of a step's detection; of the first call
    std::optional<double> pairs_ms{},
        manifolds_ms{}; ///< parts of a step: poses and World::step(); manifolds. Oncollide's
    double contacts = 0;
};

/// Detection at these poses, all contenders in turns; oncollide's line is first. The least of the repeats counts, for
/// each step.
std::vector<ContactRow> race(const ContactScene& scene, const ContactSteps& steps, const ContactContenders& contenders,
                             int threads, int repeats);

} // namespace oncollide::tools
