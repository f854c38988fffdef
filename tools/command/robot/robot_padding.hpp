#pragma once
#include <string>
#include <vector>

#include "cli/arguments.hpp"
#include "robot/robot_world.hpp"

namespace oncollide::tools {

/// How close links may come to others, and which contacts are allowed.
struct PaddingOptions {
    double environment = 0, self = 0;
    std::vector<std::string> links;   ///< LINK=LENGTH
    std::vector<std::string> allowed; ///< LINK=LINK or LINK=BODY
};
void add_padding_options(Arguments command, PaddingOptions& options);

/// Throws Error{usage} for names that do not exist.
void set_padding(const PaddingOptions& options, const RobotWorld& environment, Robot& robot);

} // namespace oncollide::tools
