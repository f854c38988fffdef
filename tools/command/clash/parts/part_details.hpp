#pragma once
#include <string>

namespace oncollide::tools {

/// Properties of a part from the extras of its glTF node; an empty text is an unknown property.
struct PartDetails {
    double deflection =
        0; ///< the part's true surface and its mesh are nowhere farther apart; in the unit of the report
    std::string part_class, guid, type, storey, discipline;
};

/// Reads the members "deflection" (metres), "class", "guid", "type", "storey" and "discipline"; ignores members of
/// other names and types.
/// @param extras  JSON or empty
/// @param scale   units of the report per metre
PartDetails details_of(const std::string& extras, double scale);

/// A class for people: "Wall" of IfcWall and IfcWallStandardCase.
std::string class_text(const std::string& part_class);

} // namespace oncollide::tools
