#pragma once
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace oncollide::tools {

/// A copy of this process in which the graphics driver is loaded: if the driver crashes or runs out of memory, only the
/// copy ends. A command makes the copy before other threads start and before files are read, because the copy keeps all
/// memory of that moment and one thread. The driver's own messages are dropped, except with ONCOLLIDE_LOG=debug.
/// Systems without fork() serve in this process.
class GraphicsProcess {
public:
    using Serve = std::function<std::string(std::string_view request)>;

    /// @param serve  runs in the copy. If the system allows no further process, requests fail.
    explicit GraphicsProcess(Serve serve);
    /// Ends the copy.
    ~GraphicsProcess();
    GraphicsProcess(const GraphicsProcess&) = delete;
    GraphicsProcess& operator=(const GraphicsProcess&) = delete;

    /// Returns the result of `serve` for the request, whose parts are joined. Throws the Error that it threw, and
    /// Error{no_gpu} if the copy has ended or lacks memory; the message says how, and names the limit of memory if
    /// there is one.
    std::string request(std::span<const std::string_view> parts);

private:
    [[noreturn]] void fail();

    Serve serve_;
    int socket_ = -1;
    int process_ = 0;   ///< 0: ended, or none
    std::string fault_; ///< how it ended
};

} // namespace oncollide::tools
