#pragma once
#include <string>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/pipeline/settings.hpp>

#include "hard/body_forms.hpp"
#include "hard/tally.hpp"

namespace oncollide::tools {

/// The pipeline's result for a pair.
struct BodyResult {
    Verdict verdict = Verdict::separate;
    ContactKind kind = ContactKind::unknown;
    double bound = 0;
    bool listed = false; ///< false: the broad phase rejected the pair
};

/// True if an exact level is on and not skipped.
bool decides(const Settings& settings);
/// True if FCL, which may err, must agree with the exact tests.
bool fcl_decides(const Settings& settings);
/// Compares one result with the truth: verdict, kind and bound. Where FCL errs, a pair may stay undecided.
void judge(const PairTruth& truth, const Settings& settings, const BodyResult& result, Tally& tally,
           const std::string& what);

} // namespace oncollide::tools
