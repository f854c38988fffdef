#pragma once
#include <string>

namespace oncollide {

/// A number as people write it, with at least `digits` significant digits but without zeros at its end: 0.025, 12.5,
/// 12346. All digits before the point are shown; an exponent only below 0.0001 and from 1e15 on.
std::string plain_number(double value, int digits);

/// The same for a measure, with the digits before the point in groups of three from 10,000 on.
std::string plain_measure(double value, int digits);

} // namespace oncollide
