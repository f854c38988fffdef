#pragma once
#include <string>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/pipeline/settings.hpp>

#include "hard/body_forms.hpp"
#include "hard/tally.hpp"

namespace oncollide::tools {

/// What the pipeline says of a pair.
struct BodyResult {
    Verdict verdict = Verdict::separate;
    ContactKind kind = ContactKind::unknown;
    double bound = 0;
    bool listed = false; ///< false: the broad phase left the pair out
};

/// True when an exact level is on and not skipped.
bool decides(const Settings& settings);
/// True when FCL, which may err, must agree with what exact tests say.
bool fcl_decides(const Settings& settings);
/// Holds one result against the truth: verdict, kind and bound. Where FCL errs a pair may stay open.
void judge(const PairTruth& truth, const Settings& settings, const BodyResult& result, Tally& tally,
           const std::string& what);

} // namespace oncollide::tools
