#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/gl/picture.hpp>

#include "render/graphics_process.hpp"

namespace oncollide::tools {

/// A Painter in a process of its own: a graphics driver that crashes costs the pictures and nothing else. Make it
/// before a command reads anything; the driver is loaded when it is first used.
class PainterProcess {
public:
    /// @param gpu  the device, as for Painter
    explicit PainterProcess(int gpu = -1);

    /// Loads the driver. Throws Error{no_gpu}.
    void open();
    /// As Painter::draw(). Throws Error{no_gpu}; later calls then throw it, too.
    std::vector<std::uint8_t> draw(const Picture& picture);

private:
    GraphicsProcess process_;
};

} // namespace oncollide::tools
