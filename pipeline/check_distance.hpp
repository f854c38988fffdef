#pragma once

namespace oncollide {

/// Throws Error{usage} for a tolerance or a limit that is negative or NaN.
void check_distance(double tolerance, double farthest);

} // namespace oncollide
