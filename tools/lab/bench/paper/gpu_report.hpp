#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <oncollide/base/text_sink.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>

namespace oncollide::tools {

/// The figures of `bench gpu`: printed as a table while they come in, then written as JSON.
class GpuReport {
public:
    using Value = std::variant<std::uint64_t, double, std::string, bool>;
    using Values = std::vector<std::pair<std::string, Value>>;

    /// Begins a part of the table. All of its rows have the same names of values.
    void begin(const std::string& name, const std::string& title);
    void row(const std::string& what, const std::string& backend, const Values& values);
    /// Says why measurements of the part are left out.
    void leave_out(const std::string& why);

    void write_json(TextSink& out, const GpuInfo& gpu, const std::vector<std::pair<std::string, std::int64_t>>& limits,
                    const std::string& sizes, double limit_s, double seconds) const;

private:
    struct Row {
        std::string what, backend;
        Values values;
    };
    struct Part {
        std::string name, title;
        std::vector<std::string> left_out;
        std::vector<Row> rows;
    };
    std::vector<Part> parts_;
};

} // namespace oncollide::tools
