#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>

#include <oncollide/robots/robot.hpp>

namespace oncollide::test {

/// Two links, or a link and a body (its slot plus 1,000).
using Key = std::pair<std::uint32_t, std::uint32_t>;

inline Key key_of(const RobotDistance& d)
{
    return d.other == RobotFinding::no_link ? Key(d.link, 1000 + d.body.slot) : Key(std::minmax(d.link, d.other));
}

} // namespace oncollide::test
