#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "play/play.hpp"
#include "view/page_frame.hpp"
#include "view/page_trees.hpp"
#include "view/three_js.hpp"

namespace oncollide::tools {

Option add_view_limit(Arguments command, int& limit);
/// Checks before any work that the page can be written and that its limit is valid; see check_files(). An empty `file`:
/// no page is requested.
/// @param option  the option that names the page
void check_view(const char* option, const std::string& file, int limit, const OutputOptions& outputs,
                const std::vector<std::string>& inputs);

/// A run as one HTML page: the scene in 3D, frame by frame, with verdicts, pairs and trees. It needs no network. Format
/// and limits: docs/view.md.
///
/// The page has a size limit. If a run does not fit, only every second, fourth, eighth ... frame is kept, pairs of
/// large frames are left out, meshes are simplified, and trees are left out; the page and summary() say so.
class ViewPage final : public FrameSink {
public:
    struct Options {
        std::string file;                    ///< file to write
        std::size_t most_bytes = 40'000'000; ///< size limit of the file
        bool separate = false;               ///< also keep separate pairs
        std::size_t frames = 0;              ///< number of frames that will come; 0: not known
        int threads = 1;
        double metres = 1;     ///< per unit of the scene
        std::string results{}; ///< results file of the frames; empty: they come from a run
    };
    /// Keeps references to both. Throws Error{no_input} without three.js, Error{usage} if not even one frame of this
    /// many bodies fits.
    ViewPage(const Scene& scene, const Pipeline& pipeline, const Options& options);

    /// Adds the frame that the pipeline ran last.
    void add(const FrameView& frame) override;
    /// Throws Error{cannot_write}. Does nothing before the first frame.
    void close() override;
    /// A summary of the file: "out.html: 3.1 MB, 60 frames".
    const std::string& summary() const { return summary_; }

private:
    struct Kept {
        nlohmann::json header;
        std::string block; ///< base64
    };
    struct Shown; ///< data that is made when the page is written
    /// The kept frame that lacks the most pairs.
    struct LeftOut {
        std::uint64_t frame = 0, pairs = 0, of = 0; ///< of: number of pairs that it would list
    };
    std::size_t room_for_geometries() const;
    std::size_t room_left() const;
    LeftOut most_left_out() const;
    void thin_out();
    Shown shown() const;
    void add_model(Shown& shown, std::uint32_t g, std::uint64_t cap) const;
    void add_all_trees(Shown& shown) const;
    static void add_levels(Shown& shown, std::uint32_t g, std::string_view name,
                           const std::vector<PageTrees::Level>& levels);
    void add_notes(Shown& made) const;
    nlohmann::json header_of(Shown& made) const;
    PageBlock bodies() const;
    void summarize(const Shown& shown, std::size_t size);

    const Scene& scene_;
    const Pipeline& pipeline_;
    Options options_;
    ThreeJs three_;
    DeformingModels deforming_;
    bool names_ = true;                      ///< there is room for the bodies' names
    std::size_t room_ = 0, frames_room_ = 0; ///< bytes for all scene data; for frames
    std::unique_ptr<PageFrames> frames_;
    std::vector<Kept> kept_;
    std::size_t kept_bytes_ = 0;
    std::uint64_t step_ = 1, seen_ = 0; ///< every step_-th frame is kept; frames seen
    std::string summary_;
};

} // namespace oncollide::tools
