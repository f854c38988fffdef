#pragma once
#include "tools/run_command.hpp"

namespace oncollide::test {

inline const char* const chromium = "/usr/bin/chromium"; ///< Debian's; may be missing

/// Runs Chromium, headless, on a page. On a busy machine one start in ten hangs, and is repeated.
inline Outcome browse(const TemporaryFolder& folder, std::vector<std::string> arguments)
{
    const std::vector<std::string> always{"30",
                                          chromium,
                                          "--headless",
                                          "--no-sandbox",
                                          "--hide-scrollbars",
                                          "--no-first-run",
                                          "--disable-background-networking",
                                          "--host-resolver-rules=MAP * ~NOTFOUND",
                                          "--user-data-dir=" + (folder / "profile").string()};
    arguments.insert(arguments.begin(), always.begin(), always.end());
    Surroundings around;
    around.folder = folder.path();
    around.environment.emplace_back("HOME", folder.path().string());
    Outcome outcome;
    for (int tries = 0; tries < 5; ++tries) {
        outcome = run_program("/usr/bin/timeout", arguments, around);
        if (outcome.code != 124) break;
    }
    return outcome;
}

} // namespace oncollide::test
