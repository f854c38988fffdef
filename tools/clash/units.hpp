#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace oncollide::tools {

/// A unit of length that CAD files are drawn in.
struct Unit {
    std::string_view name;
    double millimetres;
};

/// mm, cm, m or in. Throws Error{usage} naming `option`.
const Unit& unit_from(const std::string& option, std::string_view name);

/// "2mm", "0.1 in" or a number of `unit`, in that unit; 0 or more. Throws Error{usage} naming `option`.
double length_from(const std::string& option, const std::string& text, const Unit& unit);

/// What the files of an assembly are drawn in, and what is reported.
class Units {
public:
    /// @param texts  each a unit, for the report and all files that do not say, or PATTERN=UNIT for some files
    explicit Units(const std::vector<std::string>& texts);

    const Unit& reported() const { return *reported_; }
    /// How many reported units one of the file's is. glTF files are in metres unless a pattern says otherwise;
    /// COLLADA and 3MF files say it themselves. Throws Error{usage} for a pattern that says it of these.
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
