#include "clash/clash_pictures.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/gl/picture.hpp>

#include "clash/scenery.hpp"
#include "cli/progress.hpp"
#include "common/text.hpp"
#include "render/framing.hpp"

namespace oncollide::tools {
namespace {

constexpr int side = 360; ///< pixels, of each of the two panels
constexpr Colour colour_a{60, 120, 200}, colour_b{225, 160, 50}, red{215, 25, 30};
constexpr Colour paper{250, 250, 250};

void paste(PainterProcess& painter, const Picture& picture, Image& image, int column)
{
    const std::vector<std::uint8_t> pixels = painter.draw(picture);
    for (int y = 0; y < side; ++y)
        std::copy_n(pixels.begin() + 3 * side * y, 3 * side, image.pixels.begin() + 3 * (image.width * y + column));
}

/// The camera of a clash without a picture: from the front and above, around the contact.
ClashView plain_view(const PartList& parts, const Clash& clash)
{
    const auto size = [&](std::uint32_t part) {
        return std::get<Mesh>(parts.meshes[parts.parts[part].mesh]->data).bounds.diagonal();
    };
    Aabb box = clash.reach.overlap;
    if (clash.apart()) box.add(clash.nearest_a), box.add(clash.nearest_b);
    return {Eigen::Vector3d(0.45, -1, 0.45).normalized(), clash.where,
            std::max(0.9 * box.diagonal(), 0.15 * std::min(size(clash.a), size(clash.b)))};
}

Image draw(PainterProcess& painter, const PartList& parts, const Clash& clash, const ClashScenery& scenery)
{
    constexpr double width = 3;
    const auto& [lines, box_a, box_b, part, view] = scenery;
    Aabb whole = box_a;
    whole.add(box_b);

    Picture picture;
    picture.width = picture.height = side, picture.background = paper;
    const auto add = [&](std::uint32_t number, Colour colour, std::uint8_t alpha) {
        const Part& body = parts.parts[number];
        colour.alpha = alpha;
        picture.bodies.push_back({&std::get<Mesh>(parts.meshes[body.mesh]->data), body.pose, colour});
    };
    // The larger part is drawn first and clearer, because the smaller one may be behind its wall. A part wholly inside
    // the other is drawn unchanged.
    const bool a_is_larger = box_a.diagonal() > box_b.diagonal();
    add(a_is_larger ? clash.a : clash.b, a_is_larger ? colour_a : colour_b, 50);
    if (clash.kind == ClashKind::enclosed || clash.kind == ClashKind::duplicate)
        add(a_is_larger ? clash.b : clash.a, red, 255);
    else
        add(a_is_larger ? clash.b : clash.a, a_is_larger ? colour_b : colour_a, 110);
    for (const auto& [from, to] : lines) picture.lines.push_back({from, to, width, red});
    Image image{2 * side, side, std::vector<std::uint8_t>(std::size_t(2 * side * side * 3))};
    picture.camera = camera_from(view.from, view.middle, view.radius);
    paste(painter, picture, image, 0);
    picture.camera = camera_from(view.from, whole.centre(), 0.55 * whole.diagonal());
    // A dot marks a contact that is too small to be visible from afar.
    if (part.diagonal() < 0.08 * whole.diagonal()) picture.lines.push_back({part.centre(), part.centre(), 9, red});
    paste(painter, picture, image, side);
    return image;
}

} // namespace

ClashPictures draw_clashes(const ClashReport& report, PainterProcess& painter, std::size_t most, bool quiet)
{
    ClashPictures pictures;
    const std::vector<Clash>& list = report.found.list;
    pictures.images.resize(list.size());
    for (const Clash& clash : list) pictures.views.push_back(plain_view(report.parts, clash));
    std::vector<std::size_t> shown;
    std::size_t wanted = 0;
    for (const ClashStatus status : {ClashStatus::fresh, ClashStatus::active})
        for (std::size_t i = 0; i < list.size(); ++i)
            if (list[i].status == status && ++wanted <= most) shown.push_back(i);
    if (shown.empty()) {
        if (wanted) pictures.note = "No pictures were requested.";
        return pictures;
    }
    if (wanted > shown.size())
        pictures.note = fmt::format("Pictures of the {} most severe clashes of {}; --pictures N draws more.",
                                    grouped(shown.size()), grouped(wanted));
    Progress progress("pictures", shown.size(), quiet);
    // Pictures are drawn one by one and packed in parallel, because packing takes as long as drawing.
    constexpr std::size_t batch = 16;
    for (std::size_t begin = 0; begin < shown.size() && !pictures.failed; begin += batch) {
        std::vector<Image> images;
        try {
            for (std::size_t k = begin; k < std::min(begin + batch, shown.size()); ++k, progress.step()) {
                const Clash& clash = list[shown[k]];
                const ClashScenery scenery = scenery_of(report.parts, clash, contacts_of(report.found, clash));
                images.push_back(draw(painter, report.parts, clash, scenery));
                pictures.views[shown[k]] = scenery.view;
            }
        } catch (const Error& error) {
            if (error.kind() != ErrorKind::no_gpu) throw;
            const std::size_t drawn = begin + images.size();
            pictures.failed = true;
            pictures.note = fmt::format(
                "{}: {}", drawn ? fmt::format("Pictures of only {} clashes", grouped(drawn)) : "No pictures",
                error.what());
        }
        parallel_chunks(images.size(), 1, thread_count(report.found.world->settings()),
                        [&](std::size_t from, std::size_t to, int) {
                            for (std::size_t k = from; k < to; ++k)
                                pictures.images[shown[begin + k]] = packed_png(images[k]);
                        });
    }
    return pictures;
}

} // namespace oncollide::tools
