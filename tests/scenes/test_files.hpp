#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>

#include "temporary_folder.hpp"

namespace oncollide::test {

/// The folder of data that is not part of the project, or an empty path.
inline std::filesystem::path data_folder()
{
    const char* named = std::getenv("ONCOLLIDE_DATA");
    const std::filesystem::path folder = named != nullptr ? named : ONCOLLIDE_SOURCE_DIR "/../shared/data";
    return std::filesystem::is_directory(folder) ? folder : std::filesystem::path();
}

/// Runs `action`, which must throw an Error of that kind whose message is one line and contains all of `parts`.
template <class Action, class... Parts>
void expect_error(ErrorKind kind, Action action, Parts... parts)
{
    try {
        action();
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(kind)) << message;
        EXPECT_EQ(message.find('\n'), message.npos) << message;
        for (const std::string_view part : {std::string_view(parts)...})
            EXPECT_NE(message.find(part), message.npos) << "'" << message << "' should say '" << part << "'";
        return;
    }
    ADD_FAILURE() << "no error";
}

} // namespace oncollide::test
