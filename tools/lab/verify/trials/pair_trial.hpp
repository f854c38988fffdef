#pragma once
#include <string>

#include "truth/tally.hpp"
#include "truth/truth.hpp"
#include "verify/cases/placed_body.hpp"

namespace oncollide::tools {

/// The truth about bodies of which only this is known.
PairTruth truth_if(bool meet);

/// Tests two bodies whose truth is known by construction: with exact tests, with both bounding volumes without them,
/// with FCL's exact level. A terrain that is uncertain is compared with its bounds instead of FCL.
/// @param what  names the case in faults
void try_pair(const PlacedBody& a, const PlacedBody& b, const PairTruth& truth, const std::string& what, Tally& tally);

} // namespace oncollide::tools
