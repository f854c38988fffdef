// The commands of oncollide-lab.
#include "commands/lab.hpp"
#include "cli/command.hpp"
#include "convert/converters.hpp"
#include "peers/peers.hpp"
#include "peers/study_players.hpp"
#include "study/study_command.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/text/listed.hpp>

namespace oncollide::tools {
namespace {

/// The libraries that benchmarks compare with.
std::string peers_text()
{
    const std::vector<MissingPeer> missing = all_contenders().narrow.missing;
    std::vector<std::string> there{"FCL"}, absent;
    for (const char* library : {"Embree", "Bullet", "ODE", "CGAL"}) {
        const auto lacks = std::ranges::find(missing, library, &MissingPeer::library);
        if (lacks == missing.end())
            there.push_back(library);
        else
            absent.push_back(fmt::format("{} (Debian: {})", library, lacks->package));
    }
    return listed(there) + (absent.empty() ? "" : "; without " + listed(absent));
}

} // namespace

const Program program{
    .name = "oncollide-lab",
    .summary = "The laboratory of oncollide: benchmarks against other libraries, and judges of its results.",
    .footer =
        "'bench' measures oncollide and other libraries in one run, on the same workload, and judges all results.\n"
        "'study' does so at many accuracies. 'hard', 'fuzz' and 'manifolds' compare results with arithmetic that\n"
        "shares no code with the library. 'doctor' lists the libraries that this build compares with.\n\n"
        "Examples:\n"
        "  oncollide-lab bench many --bodies 1000\n"
        "  oncollide-lab bench narrow part.stl fixture.stl --distances 0,1,10\n"
        "  oncollide-lab study many --frames 20 --peers all --html many.html\n"
        "  oncollide-lab hard --count 10000 --threads 0\n"
        "  oncollide-lab fuzz --scenes 100000 --threads 0\n"
        "Exit codes: 0 success, 64 usage, 65 bad data, 66 no input, 70 a wrong result or an internal fault, 71 no\n"
        "GPU, 73 cannot write, 130 interrupted.\n"
        "Environment: ONCOLLIDE_DATA names the data folder; ONCOLLIDE_LOG=info or debug prints more to standard\n"
        "error, NO_COLOR=1 turns off colours. Scenes, pages and parts of results: see 'oncollide --help'.",
    .add_commands = [](Arguments app) {
        read_converted_files();
        app.at_most_one_command(); // words after a command belong to it: `study hard` plays the scene hard
        add_bench(app);
        add_study(app, "oncollide-lab study", study_peers());
        add_hard(app);
        add_fuzz(app);
        add_manifolds(app);
        add_league(app);
        add_doctor(app, peers_text);
        add_reference(app);
    }};

} // namespace oncollide::tools
