#include "cli/standard_output.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

#include "cli/log.hpp"

namespace oncollide::tools {
namespace {

int fault = 0; ///< errno of the first write that failed

void note(bool written)
{
    if (!written && !fault) fault = errno;
}

} // namespace

void write_to_stdout(std::string_view text, bool taken)
{
    if (taken) return write_to_stderr(text);
    note(std::fwrite(text.data(), 1, text.size(), stdout) == text.size());
}

void flush_stdout()
{
    note(std::fflush(stdout) == 0);
}

void check_stdout()
{
    flush_stdout();
    if (fault)
        throw Error(ErrorKind::cannot_write, fmt::format("standard output: cannot write: {}", std::strerror(fault)));
}

} // namespace oncollide::tools
