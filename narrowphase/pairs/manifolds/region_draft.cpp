#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

void RegionDraft::begin(RegionKind kind, bool open, double rounding_of_positions)
{
    ManifoldRegion blank{};
    blank.kind = kind, blank.open = open;
    blank.normal.setZero(), blank.centre.setZero();
    region = blank, candidates.clear(), contacts.clear(), faces[0].clear(), faces[1].clear();
    rounding = rounding_of_positions, least_depth = 0;
    shared_.clear(), candidate_of_.clear();
}

void RegionDraft::add_shared(const ManifoldCandidate& candidate)
{
    bool is_new;
    const std::uint32_t number = shared_.add(splitmix(candidate.a) ^ candidate.b, is_new);
    if (is_new) {
        candidate_of_.push_back(static_cast<std::uint32_t>(candidates.size()));
    } else if (ManifoldCandidate& known = candidates[candidate_of_[number]];
               known.a == candidate.a && known.b == candidate.b) {
        if (known.normal.isZero(0)) known.normal = candidate.normal; // another face at the edge is opposite
        return;
    }
    candidates.push_back(candidate);
}

} // namespace oncollide
