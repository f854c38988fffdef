#pragma once
#include <optional>
#include <string>
#include <vector>

#include "robot/robot_world.hpp"

namespace oncollide::tools {

/// Clearances of links, and contacts that are allowed.
struct PaddingOptions {
    std::optional<double> environment, self; ///< metres
    std::vector<std::string> links;          ///< LINK=LENGTH
    std::vector<std::string> allowed;        ///< LINK=NAME
    std::string file;                        ///< YAML with all of these
};
void add_padding_options(Arguments command, PaddingOptions& options);

/// The robot's clearances and allowed contacts.
struct PaddingRules {
    RobotPadding padding{};
    std::vector<AllowedContact> allowed{};
};

/// The links of a robot and the bodies of its environment, by their names.
struct PaddingNames {
    const Robot& robot;
    const RobotWorld& environment;

    std::optional<std::uint32_t> link(const std::string& name) const;
    std::optional<BodyId> body(const std::string& name) const;
    /// "no link 'hnad'; did you mean 'hand'?"
    std::string no_link(const std::string& name) const;
    std::string no_link_or_body(const std::string& name) const;
};

/// Reads a YAML file. Throws Error{no_input}, Error{bad_data} that names the line, and Error{usage} in a build without
/// yaml-cpp.
PaddingRules read_padding_file(const std::string& path, const PaddingNames& names);

/// Sets the rules. Options of the command line replace rules of the file. Throws Error{usage} for names that do not exist.
void set_padding(const PaddingOptions& options, const RobotWorld& environment, Robot& robot);

} // namespace oncollide::tools
