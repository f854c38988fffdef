#pragma once
#include <stdexcept>
#include <string>

#include <oncollide/base/printable.hpp>

namespace oncollide {

/// What went wrong, as the process exit code that the command line gives for it (numbers after BSD sysexits).
enum class ErrorKind : int {
    usage = 64,        ///< the caller requested something that does not exist or makes no sense
    bad_data = 65,     ///< a file or an array was read and its content is invalid
    no_input = 66,     ///< a file is missing or unreadable
    internal = 70,     ///< a fault of oncollide itself
    no_gpu = 71,       ///< the requested backend has no device to run on
    cannot_write = 73, ///< an output file cannot be created or written
};

/// The one exception of the library. The message says where, what, and what would be valid; it stands alone on a line
/// and is safe to print: what names in a file may hold is escaped (printable).
/// Thrown at load or creation only, never half-way through a frame.
class Error : public std::runtime_error {
public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(printable(message)), kind_(kind) {}
    ErrorKind kind() const { return kind_; }

private:
    ErrorKind kind_;
};

/// Throws Error{bad_data}: "NAME: WHAT".
[[noreturn]] inline void refuse(const std::string& name, const std::string& what)
{
    throw Error(ErrorKind::bad_data, name + ": " + what);
}

} // namespace oncollide

/// A contract of the caller; checked in debug and sanitizer builds only.
#ifdef ONCOLLIDE_ASSERTIONS
#include <cstdio>
#include <cstdlib>
#define ONCOLLIDE_ASSERT(condition)                                                                                    \
    ((condition)                                                                                                       \
         ? void(0)                                                                                                     \
         : (std::fprintf(stderr, "%s:%d: contract broken: %s\n", __FILE__, __LINE__, #condition), std::abort()))
#else
#define ONCOLLIDE_ASSERT(condition) void(0)
#endif
