#pragma once
#include <stdexcept>
#include <string>

// The shared library (BUILD_SHARED_LIBS) exports the classes and functions marked ONCOLLIDE_API, all of them in
// installed headers. ONCOLLIDE_LOCAL hides a member class of an exported class.
#ifdef __GNUC__
#define ONCOLLIDE_API __attribute__((visibility("default")))
#define ONCOLLIDE_LOCAL __attribute__((visibility("hidden")))
#else
#define ONCOLLIDE_API
#define ONCOLLIDE_LOCAL
#endif

namespace oncollide {

/// The kind of an error. The values are the exit codes of the command line (after BSD sysexits).
enum class ErrorKind : int {
    usage = 64,        ///< the caller requested something that does not exist or makes no sense
    bad_data = 65,     ///< a file or an array was read and its content is invalid
    no_input = 66,     ///< a file is missing or unreadable
    internal = 70,     ///< a fault of oncollide itself
    no_gpu = 71,       ///< the requested backend has no device to run on
    cannot_write = 73, ///< an output file cannot be created or written
};

/// The only exception type of the library. The message names the location, the problem and the valid values. It fits on
/// one line and is safe to print: characters from names in files are escaped (printable()).
/// A call that throws has changed nothing, unless its comment says otherwise; a frame never ends half-way.
class ONCOLLIDE_API Error : public std::runtime_error {
public:
    Error(ErrorKind kind, const std::string& message);
    ErrorKind kind() const { return kind_; }

private:
    ErrorKind kind_;
};

/// Throws Error{bad_data} with the message "`name`: `what`".
[[noreturn]] inline void refuse(const std::string& name, const std::string& what)
{
    throw Error(ErrorKind::bad_data, name + ": " + what);
}

} // namespace oncollide

/// Asserts a precondition on the caller; checked in debug and sanitizer builds only.
#ifdef ONCOLLIDE_ASSERTIONS
#include <cstdio>
#include <cstdlib>
#define ONCOLLIDE_ASSERT(condition)                                                                                    \
    ((condition)                                                                                                       \
         ? void(0)                                                                                                     \
         : (std::fprintf(stderr, "%s:%d: contract broken: %s\n", __FILE__, __LINE__, #condition), std::abort()))
/// Asserts that a structure's validate() returns no fault: an empty text.
#define ONCOLLIDE_ASSERT_VALID(fault)                                                                                  \
    do {                                                                                                               \
        if (const std::string text = (fault); !text.empty()) {                                                         \
            std::fprintf(stderr, "%s:%d: invariant broken: %s\n", __FILE__, __LINE__, text.c_str());                   \
            std::abort();                                                                                              \
        }                                                                                                              \
    } while (false)
#else
#define ONCOLLIDE_ASSERT(condition) void(0)
#define ONCOLLIDE_ASSERT_VALID(fault) void(0)
#endif
