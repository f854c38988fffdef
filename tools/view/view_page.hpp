#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cli/play.hpp"
#include "view/page_frame.hpp"
#include "view/three_js.hpp"

namespace oncollide::tools {

Option add_view_limit(Arguments command, int& limit);
/// Finds out before any work that a page could not be written, or that its limit makes no sense; as check_files().
/// Empty: none is requested.
/// @param option  that names the page
void check_view(const char* option, const std::string& file, int limit, const OutputOptions& outputs,
                const std::vector<std::string>& inputs);

/// A run as one HTML page to look at: the scene in 3D, frame by frame, with verdicts, pairs and trees. It needs no
/// network. Format and limits: docs/view.md.
///
/// The page has a size limit. Where a run does not fit, only every second, fourth, eighth ... frame is kept, meshes are
/// shown simplified and the lower levels of trees left out: the page and summary() say so.
class ViewPage final : public FrameSink {
public:
    struct Options {
        std::string file;                    ///< where it goes
        std::size_t most_bytes = 40'000'000; ///< of the file
        bool separate = false;               ///< keep the pairs that were found separate, too
        int threads = 1;
        std::string results{}; ///< the file that the frames are read from; empty: they are of a run
    };
    /// Keeps references to both. Throws Error{no_input} without three.js, Error{usage} if the limit does not even
    /// hold one frame of so many bodies.
    ViewPage(const Scene& scene, const Pipeline& pipeline, const Options& options);

    /// Takes in the frame that the pipeline has just run.
    void add(const FrameView& frame) override;
    /// Throws Error{cannot_write}. Does nothing before the first frame.
    void close() override;
    /// Of what was written: "out.html: 3.1 MB, 60 frames".
    const std::string& summary() const { return summary_; }

private:
    struct Kept {
        nlohmann::json header;
        std::string block; ///< base64
    };
    struct Shown; ///< what is made when the page is written
    std::size_t room_left() const;
    void thin_out();
    nlohmann::json about() const;
    Shown shown() const;
    void summarize(const Shown& shown, std::size_t size);

    const Scene& scene_;
    const Pipeline& pipeline_;
    Options options_;
    ThreeJs three_;
    bool names_ = true;                      ///< is there room for the bodies' names?
    std::size_t room_ = 0, frames_room_ = 0; ///< bytes of the file for all that depends on the scene; for frames
    std::unique_ptr<PageFrames> frames_;
    std::vector<Kept> kept_;
    std::size_t kept_bytes_ = 0;
    std::uint64_t step_ = 1, seen_ = 0; ///< every so manieth frame is kept; frames that came
    std::string summary_;
};

} // namespace oncollide::tools
