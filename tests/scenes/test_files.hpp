#pragma once
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>

namespace oncollide::test {

/// An empty folder that the destructor removes.
class TemporaryFolder {
public:
    TemporaryFolder()
    {
        std::string pattern = (std::filesystem::temp_directory_path() / "oncollide-test-XXXXXX").string();
        if (mkdtemp(pattern.data()) == nullptr) std::abort();
        path_ = pattern;
    }
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path write(const std::string& name, std::string_view content) const
    {
        std::ofstream(path_ / name, std::ios::binary) << content;
        return path_ / name;
    }

private:
    std::filesystem::path path_;
};

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
