#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace oncollide::tools {

/// A unit of length of CAD files.
struct Unit {
    std::string_view name;
    double millimetres;
};

/// mm, cm, m or in. Throws Error{usage} naming `option`.
const Unit& unit_from(const std::string& option, std::string_view name);

/// "2mm", "0.1 in" or a number of `unit`, in that unit; 0 or more. Throws Error{usage} naming `option`.
double length_from(const std::string& option, const std::string& text, const Unit& unit);

/// The units of an assembly's files and of the report.
class Units {
public:
    /// @param texts  each a unit, for the report and all files that define none, or PATTERN=UNIT for some files
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
