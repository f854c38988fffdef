#pragma once
#include "league/families/families.hpp"
#include "verify/cases/case_numbers.hpp"

// Situations from public bug reports of other libraries, with bodies and numbers of our own.
namespace oncollide::tools {

/// How the cases of a report are judged.
struct ReportTruth {
    league_question question;
    LeagueTruth (*truth)(const LeagueCase& asked);
    bool (*confirms)(const LeagueCase& asked, const LeagueTruth& truth) = nullptr;
};

/// @param situation  for people, with the report's tracker and number: "kissing boxes, fcl#415"
LeagueFamily report_family(const char* situation, const ReportTruth& truth, std::string what,
                           std::function<LeagueCase(CaseNumbers&)> make);

/// 0, or a length of either sign and any magnitude between 2^low and 2^high.
double touch_or_gap(CaseNumbers& draw, int low, int high);
/// Coordinates are whole numbers.
Eigen::Vector3d whole_point(CaseNumbers& draw, int most);
Eigen::Matrix3d turn_or_none(CaseNumbers& draw);

/// A shape at a place, with a rotation.
LeagueBody placed(Shape shape, const Eigen::Vector3d& at = Eigen::Vector3d::Zero(),
                  const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity());

/// The same case after a rotation of both bodies about the origin.
LeagueCase turned_together(LeagueCase asked, const Eigen::Matrix3d& turn);

} // namespace oncollide::tools
