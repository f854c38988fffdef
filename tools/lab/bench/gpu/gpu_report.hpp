#pragma once
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/base/text_sink.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>

#include "bench/common/result_table.hpp"

namespace oncollide::tools {

/// A part of `bench gpu`: its table, and the measurements that are left out.
struct GpuPart {
    /// @param csv  file; empty: none
    GpuPart(const std::string& name, const std::string& title, const std::string& csv)
        : name(name), title(title), table(csv, {26, 36})
    {
        table.section(name + ": " + title);
    }
    std::string name, title;
    std::vector<std::string> left_out;
    ResultTable table;

    /// Says why.
    void leave_out(const std::string& why);
};

/// The parts of a run, in order.
class GpuReport {
public:
    /// Begins a part and its table on the console; the arguments are GpuPart's.
    GpuPart& begin(const std::string& name, const std::string& title, const std::string& csv)
    {
        return parts_.emplace_back(name, title, csv);
    }
    /// Completes the CSV files.
    void commit();
    void write_json(TextSink& out, const GpuInfo& gpu, const std::vector<std::pair<std::string, std::int64_t>>& limits,
                    const std::string& sizes, double limit_s, double seconds) const;

private:
    std::deque<GpuPart> parts_;
};

} // namespace oncollide::tools
