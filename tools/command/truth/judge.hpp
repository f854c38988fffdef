#pragma once
#include <string>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/pipeline/settings.hpp>

#include "truth/tally.hpp"
#include "truth/truth.hpp"

namespace oncollide::tools {

/// The faults of a result.
struct Judgement {
    enum class Fault {
        none,
        missed, ///< `separate` for bodies that collide or are within the clearance
        wrong,  ///< a false collision, a pair left open by an exact level, a wrong kind of contact
    };
    Fault fault = Fault::none;
    const char* why = "";
    bool false_positive = false; ///< left over, but apart: allowed without an exact level
    bool broken = false;         ///< the distance contradicts the certified bound

    bool right() const { return fault == Fault::none && !broken; }
};

/// The one judge: compares a result of the pipeline with the truth, as docs/results.md promises it for these settings.
Judgement judge(const Finding& result, const PairTruth& truth, const Settings& settings);

/// Counts the same in a tally. `what` names the case.
void judge(const Finding& result, const PairTruth& truth, const Settings& settings, const std::string& what,
           Tally& tally);

/// The result of a pair that the broad phase rejected: it is certified to be farther apart than the clearance.
inline Finding unlisted(const Settings& settings)
{
    return {Verdict::separate, ContactKind::unknown, settings.clearance};
}

/// True if the bodies collide for these settings, insides and the clearance included, and rounding does not matter.
bool must_be_left_over(const PairTruth& truth, const Settings& settings);

/// True if an exact level is on and not skipped.
bool decides(const Settings& settings);
/// True if FCL, which may err, must agree with the exact tests.
bool fcl_decides(const Settings& settings);

/// A description of the difference, for messages.
std::string described(const Finding& result, const PairTruth& truth, const Judgement& judgement);

} // namespace oncollide::tools
