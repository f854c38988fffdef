#pragma once
#include <string>
#include <vector>

#include "cli/lengths.hpp"

namespace oncollide::tools {

/// The units of an assembly's files and of the report.
class Units {
public:
    /// @param texts  each is a unit, for the report and all files that define none, or PATTERN=UNIT for some files
    explicit Units(const std::vector<std::string>& texts);

    const Unit& reported() const { return *reported_; }
    /// The file's unit divided by the unit of the report. glTF files are in metres unless a pattern matches; COLLADA
    /// and 3MF files define their unit. Throws Error{usage} for a pattern that matches such a file.
    double scale_of(const std::string& file) const;

private:
    struct OfFiles {
        std::string pattern;
        const Unit* unit;
    };
    const Unit* reported_;
    std::vector<OfFiles> of_files_;
};

} // namespace oncollide::tools
