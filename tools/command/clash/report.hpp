#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/base/files/output_file.hpp>

#include "clash/baseline.hpp"
#include "clash/clashes.hpp"
#include "clash/grouping.hpp"
#include "clash/scenery.hpp"
#include "render/png.hpp"

namespace oncollide::tools {

/// The contents of every report.
struct ClashReport {
    const PartList& parts;
    const Clashes& found;
    const Unit& unit;
    ClashSettings settings;
    std::string baseline, ignore; ///< file names; empty: none
    std::vector<ResolvedClash> resolved;
    std::vector<std::string> warnings;
    PartRules rules{};
    std::int64_t time = 0; ///< seconds since 1970, UTC; pages and BCF show it
    std::string view{};    ///< the 3D page, as pages beside it name it; empty: none
    std::vector<GroupKey> group_by{};

    const std::string& name(std::uint32_t part) const { return parts.parts[part].name; }
    std::size_t count(ClashStatus status) const;
    std::size_t count(ClashStatus status, ClashKind kind) const;
    /// New clashes, then active ones, as indices in Clashes::list.
    std::vector<std::size_t> open_clashes() const;
    /// The open clashes in groups.
    std::vector<ClashGroup> groups() const { return groups_of(parts, found.list, open_clashes(), group_by); }
    const std::string& label(std::uint32_t part) const { return parts.parts[part].label; }
    std::string length(double value) const;                   ///< "1.25 mm"
    std::string position(const Eigen::Vector3d& point) const; ///< "10.25 3.5 -2", to a millionth of the assembly's size
};

/// Lines for the screen and the page: "8 new clashes: 2 enclosed, 6 crossing", and notes.
std::vector<std::string> summary(const ClashReport& report);
/// The reason why a part is not closed: "60 open edges, 460 mm long"; "" if parts were not mended.
/// @param before  text in front of it, if there is any
std::string why_open(const ClashReport& report, std::uint32_t part, std::string_view before = "");
/// The measured overlap or gap: "ball of 98.1 mm"; of a part that is not closed, the length of the contact curve.
std::string measure_text(const ClashReport& report, const Clash& clash);
/// "2026-03-01 12:00 UTC"
std::string time_text(std::int64_t seconds);

/// The `most` worst new clashes, then the clashes of the baseline, one row per clash, in groups if there are any.
std::string clash_table(const ClashReport& report, std::size_t most);

void write_json(TextSink& out, const ClashReport& report);
void write_csv(OutputFile& file, const ClashReport& report);
/// JUnit XML: a new clash is a failure, a known clash is skipped, a resolved clash passes.
void write_junit(OutputFile& file, const ClashReport& report);

struct ClashPictures {
    std::vector<std::string> images; ///< PNG files, in the order of Clashes::list; empty if there is none
    std::vector<ClashView> views;    ///< the same for all clashes
    std::string note;                ///< why pictures are missing; empty: each clash has one
    bool failed = false;             ///< the pictures could not be drawn
};
/// Writes one self-contained page.
void write_page(OutputFile& file, const ClashReport& report, const ClashPictures& pictures);

} // namespace oncollide::tools
