#pragma once
#include <vector>

namespace oncollide::tools {

// 0 of nothing.
double median(std::vector<double> values);
double mean(const std::vector<double>& values);

} // namespace oncollide::tools
