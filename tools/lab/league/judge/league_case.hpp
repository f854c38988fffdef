#pragma once
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/scenes/geometry.hpp>

#include <oncollide/league.h>

namespace oncollide::tools {

/// A body of a case.
struct LeagueBody {
    GeometryData geometry{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    bool solid = false; ///< a mesh that is closed, with its inside

    /// Diameter, or a bound of it; of a half-space 0.
    double size() const;
};

/// The area where a face of b lies on a face of a, in families of contacts that know it.
struct Footprint {
    Eigen::Vector3d centre, normal; ///< centre of the common area; unit, from a to b
    double depth;                   ///< metres that b is in a
};

/// A question about bodies, with all numbers that it needs.
struct LeagueCase {
    league_question question = LEAGUE_MEET;
    LeagueBody a{}, b{}; ///< of pairs: not used
    Eigen::Vector3d from = Eigen::Vector3d::Zero(), motion = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
    std::vector<LeagueBody> bodies{}; ///< of pairs: boxes
    std::optional<Footprint> footprint{};

    bool has_b() const { return question < LEAGUE_RAY; }
    /// The pose of b at a time from 0 to 1 of its motion.
    Eigen::Isometry3d pose_of_b(double time) const;
};

/// The same, with all numbers rounded to float.
LeagueCase rounded_to_float(LeagueCase asked);

/// A case in the form of league.h. Keeps the case, and the data that the form points to.
class AskedCase {
public:
    explicit AskedCase(LeagueCase asked);
    AskedCase(const AskedCase&) = delete;

    const league_case& view() const { return view_; }

private:
    struct Columns {
        std::vector<double> vertices;
        std::vector<std::uint32_t> triangles;
    };
    league_body form_of(const LeagueBody& body);

    LeagueCase case_;
    std::vector<Columns> columns_;
    std::vector<league_body> bodies_;
    league_case view_{};
};

/// The case for the page: kinds by name, vertices and triangles as lists.
nlohmann::json json_of(const league_case& asked);
/// The bodies as an OBJ file: an object each, at their poses; shapes as meshes around them. A ray is a line.
std::string obj_of(const LeagueCase& asked);

/// A C++ program that gives the case to the library of an adapter, the file that it is started with, and prints the
/// result: for a debugger, and for reports to the library's authors.
std::string program_of(const league_case& asked, const std::string& library);

std::string_view name_of(league_question question); ///< "meet"
std::string_view name_of(league_kind kind);         ///< "half-space"

} // namespace oncollide::tools
