#pragma once
#include <array>
#include <string>
#include <vector>

#include <oncollide/base/output_file.hpp>

#include "clash/clashes.hpp"
#include "clash/known_pairs.hpp"
#include "render/png.hpp"

namespace oncollide::tools {

/// What every report says.
struct ClashReport {
    const PartList& parts;
    const Clashes& found;
    const Unit& unit;
    ClashSettings settings;
    std::string baseline, ignore; ///< files; empty: none
    std::vector<FixedClash> fixed;
    std::vector<std::string> warnings;

    const std::string& name(std::uint32_t part) const { return parts.parts[part].name; }
    std::size_t count(ClashStatus status) const;
    std::size_t count(ClashStatus status, ContactKind kind) const;
    std::string length(double value) const; ///< "1.25 mm"
};

inline constexpr std::array clash_kinds{ContactKind::enclosed, ContactKind::crossing, ContactKind::touching,
                                        ContactKind::near};

/// "8 new clashes: 2 enclosed, 6 crossing", and what else was found, for the screen and the page.
std::vector<std::string> summary(const ClashReport& report);
/// How deep, or how near: "at most 0.2 mm thick, a vertex 0.1 mm deep".
std::string measure_text(const ClashReport& report, const Clash& clash);
/// "10.25 3.5 -2"
std::string point_text(const Eigen::Vector3d& point);

/// The worst `most` clashes that are new, then those that the baseline has, one row each.
std::string clash_table(const ClashReport& report, std::size_t most);

void write_json(OutputFile& file, const ClashReport& report);
void write_csv(OutputFile& file, const ClashReport& report);
/// JUnit XML: a new clash is a failure, one that is known is skipped, one that is fixed passes.
void write_junit(OutputFile& file, const ClashReport& report);

/// PNG files by place in Clashes::list; empty where there is none.
struct ClashPictures {
    std::vector<std::string> images;
    std::string note; ///< why there are no more of them; empty: each clash has one
};
/// One page that needs nothing else.
void write_page(OutputFile& file, const ClashReport& report, const ClashPictures& pictures);

} // namespace oncollide::tools
