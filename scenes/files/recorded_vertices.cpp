#include <oncollide/scenes/files/deformation_entry.hpp>

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/files/paths.hpp>
#include <oncollide/scenes/deformation.hpp>
#include <oncollide/scenes/files/tables/frame_source.hpp>

namespace oncollide {

namespace {

class RecordedVertices final : public Deformation {
public:
    explicit RecordedVertices(const FrameFile& file)
        : name_(file.file.string()),
          source_(open_frames(file, 3, "vertices", std::numeric_limits<std::uint32_t>::max()))
    {
        frames = source_->frames;
        Json entry{{"file", portable_name(absolute_path(file.file))}};
        if (!file.path.empty()) entry["path"] = file.path;
        try {
            recipe = entry.dump();
        } catch (const Json::exception&) {
            throw Error(ErrorKind::bad_data, "the path of its file is not UTF-8 text");
        }
    }

    void move(const Mesh&, double time, std::span<Eigen::Vector3d> positions) override
    {
        if (source_->rows != positions.size())
            refuse(name_, fmt::format("has {} vertices, and the mesh has {}", source_->rows, positions.size()));
        const std::uint64_t frame = std::min(static_cast<std::uint64_t>(time), frames - 1);
        source_->read(frame, 0, positions.size(), numbers_);
        constexpr double farthest = 1e15;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const Eigen::Map<const Eigen::Vector3d> position(&numbers_[3 * i]);
            if (!(position.cwiseAbs().maxCoeff() <= farthest) || !position.allFinite())
                refuse(name_, fmt::format("frame {}: vertex {}: ({}, {}, {}) is not finite, or farther than {} m from "
                                          "the origin",
                                          frame, i, position.x(), position.y(), position.z(), farthest));
            positions[i] = position;
        }
    }

private:
    std::string name_;
    std::unique_ptr<FrameSource> source_;
    std::vector<double> numbers_; ///< of the frame read last
};

} // namespace

std::shared_ptr<Deformation> open_vertices(const std::filesystem::path& path, const std::string& dataset)
{
    const bool npy = path.extension() == ".npy";
    return std::make_shared<RecordedVertices>(FrameFile{path, npy ? "" : dataset});
}

} // namespace oncollide
