#include <charconv>
#include <fstream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>

#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Seven columns: numerator and denominator of x, y and z, then the truth of the query from t0 to t1, which does not
/// apply to its ends. Denominators are powers of two, so the quotients are exact.
Vector3d point_of(const std::string& line, const std::string& where)
{
    std::array<double, 7> column{};
    const char *at = line.data(), *end = at + line.size();
    for (std::size_t k = 0; k < column.size(); ++k) {
        const auto [rest, error] = std::from_chars(at, end, column[k]);
        const bool last = k + 1 == column.size();
        if (error != std::errc{} || (last ? rest != end : rest == end || *rest != ','))
            throw Error(ErrorKind::bad_data, where + ": expected seven numbers, separated by commas");
        at = rest + 1;
    }
    return {column[0] / column[1], column[2] / column[3], column[4] / column[5]};
}

/// Eight rows per query: four points at t0, and the same four at t1.
void read_queries(const std::filesystem::path& path, bool edges, const CaseFamily& add)
{
    check_readable(path);
    std::ifstream file(path);
    if (!file) throw Error(ErrorKind::no_input, fmt::format("{}: cannot be read", path.string()));
    std::string line;
    std::vector<Vector3d> p;
    for (int number = 1; std::getline(file, line); ++number) {
        p.push_back(point_of(line, fmt::format("{}: line {}", path.string(), number)));
        if (p.size() < 4) continue;
        const Mesh a = edges ? mesh_of({p[0], p[1], p[1]}) : mesh_of({p[0], p[0], p[0]});
        const Mesh b = edges ? mesh_of({p[2], p[3], p[3]}) : mesh_of({p[1], p[2], p[3]});
        add(fmt::format("{}, rows {} to {}", path.stem().string(), number - 3, number), a, b, at(0, 0, 0));
        p.clear();
    }
    if (!p.empty())
        throw Error(ErrorKind::bad_data, fmt::format("{}: ends within a query of eight rows", path.string()));
}

} // namespace

std::vector<BodyCase> query_cases(const std::filesystem::path& data)
{
    std::vector<BodyCase> cases;
    const std::filesystem::path folder = data / "queries";
    if (data.empty() || !is_folder(folder)) return cases;
    for (const auto& [name, family] :
         {std::pair("erleben-spikes", "Erleben's spikes"), std::pair("erleben-wedges", "Erleben's wedges"),
          std::pair("erleben-cube-internal-edges", "Erleben's internal edges")}) {
        read_queries(folder / name / "vertex-face.csv", false, {cases, family});
        read_queries(folder / name / "edge-edge.csv", true, {cases, family});
    }
    return cases;
}

} // namespace oncollide::tools
