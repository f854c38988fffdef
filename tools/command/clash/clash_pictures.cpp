#include "clash/clash_pictures.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/gl/picture.hpp>

#include "cli/progress.hpp"
#include "common/text.hpp"
#include "render/framing.hpp"

namespace oncollide::tools {
namespace {

constexpr int side = 360; ///< pixels, of each of the two panels
constexpr Colour colour_a{60, 120, 200}, colour_b{225, 160, 50}, red{215, 25, 30};
constexpr Colour paper{250, 250, 250};

/// The contents of a picture.
struct Subject {
    std::vector<Picture::Line> lines;
    std::vector<Eigen::Vector3d> points;
};

Subject subject_of(const Clashes& found, const PartList& parts, const Clash& clash)
{
    constexpr double width = 3;
    Subject subject;
    if (clash.apart())
        subject.lines.push_back({clash.nearest_a, clash.nearest_b, width, red});
    else if (clash.kind != ClashKind::enclosed && clash.kind != ClashKind::duplicate) {
        const PairOfBodies pair = found.pair(clash);
        const std::vector<Contact> contacts = found.world->pairs().contacts(pair.a, pair.b);
        constexpr std::size_t most = 100'000; // more would not be distinguishable
        for (std::size_t k = 0; k < contacts.size(); k += 1 + contacts.size() / most)
            subject.lines.push_back({contacts[k].ends[0], contacts[k].ends[1], width, red});
    }
    for (const Picture::Line& line : subject.lines)
        subject.points.push_back(line.from), subject.points.push_back(line.to);
    if (clash.kind == ClashKind::enclosed || clash.kind == ClashKind::duplicate)
        for (const std::uint32_t part : {clash.a, clash.b}) {
            const auto& mesh = std::get<Mesh>(parts.meshes[parts.parts[part].mesh]->data);
            for (const Eigen::Vector3d& v : mesh.vertices) {
                const Eigen::Vector3d p = parts.parts[part].pose * v;
                const Aabb& box = clash.reach.overlap;
                if ((p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all())
                    subject.points.push_back(p);
            }
        }
    return subject;
}

/// The direction, of sixteen, from which the points spread over the largest area, preferably from above
/// and the front.
Eigen::Vector3d good_side(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& middle)
{
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : points) spread += (p - middle) * (p - middle).transpose();
    Eigen::Vector3d best = Eigen::Vector3d(0.45, -1, 0.45).normalized();
    if (!(spread.trace() > 0) || !spread.allFinite()) return best;
    spread /= spread.trace();
    double most = -1, later = 0;
    for (const Eigen::Vector3d& from : good_sides()) {
        const Eigen::Vector3d x = Eigen::Vector3d(0, 0, 1).cross(from).normalized(), y = from.cross(x);
        const double xx = x.dot(spread * x), yy = y.dot(spread * y), xy = x.dot(spread * y);
        // The area of the spread; for points on a line, its length.
        const double seen = std::sqrt(std::max(xx * yy - xy * xy, 0.0)) + 0.1 * (xx + yy) - later;
        later += 0.002;
        if (seen > most) most = seen, best = from;
    }
    return best;
}

Aabb box_of(const PartList& parts, std::uint32_t part)
{
    Aabb box;
    const auto& mesh = std::get<Mesh>(parts.meshes[parts.parts[part].mesh]->data);
    for (const Eigen::Vector3d& v : mesh.vertices) box.add(parts.parts[part].pose * v);
    return box;
}

void paste(PainterProcess& painter, const Picture& picture, Image& image, int column)
{
    const std::vector<std::uint8_t> pixels = painter.draw(picture);
    for (int y = 0; y < side; ++y)
        std::copy_n(pixels.begin() + 3 * side * y, 3 * side, image.pixels.begin() + 3 * (image.width * y + column));
}

/// The subject of a picture and its camera.
struct Scenery {
    Subject subject;
    Aabb box_a, box_b, part; ///< part: around the contact
    ClashView view;
};

Scenery scenery_of(const ClashReport& report, const Clash& clash)
{
    const PartList& parts = report.parts;
    Scenery s{.subject = subject_of(report.found, parts, clash),
              .box_a = box_of(parts, clash.a),
              .box_b = box_of(parts, clash.b),
              .part = clash.reach.overlap,
              .view = {}};
    for (const Eigen::Vector3d& p : s.subject.points) s.part.add(p);
    Aabb whole = s.box_a;
    whole.add(s.box_b);
    const double smaller = std::min(s.box_a.diagonal(), s.box_b.diagonal());
    // The camera is near enough to show the contact, far enough to recognise the parts, and not nearer than floats can
    // draw.
    const double near = std::max({0.9 * s.part.diagonal(), 0.15 * smaller, 1e-4 * whole.diagonal()});
    s.view = {good_side(s.subject.points, s.part.centre()), s.part.centre(), std::min(near, 0.6 * whole.diagonal())};
    return s;
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

Image draw(PainterProcess& painter, const ClashReport& report, const Clash& clash, const Scenery& scenery)
{
    const auto& [subject, box_a, box_b, part, view] = scenery;
    const PartList& parts = report.parts;
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
    picture.lines = subject.lines;
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
                const Scenery scenery = scenery_of(report, list[shown[k]]);
                images.push_back(draw(painter, report, list[shown[k]], scenery));
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
