#include <oncollide/broadphase/aabb_checks.hpp>

#include <string>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

void refuse_unusable(const Aabb& box, const char* what, std::size_t number)
{
    if (usable(box)) return;
    std::string text = what;
    text.append(" ").append(std::to_string(number)).append(": the box is not finite, or beyond 1e30 m");
    throw Error(ErrorKind::bad_data, text);
}

} // namespace

void refuse_unusable(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies)
{
    for (std::uint32_t body : bodies) refuse_unusable(boxes[body], "body", body);
}

void refuse_unusable_queries(std::span<const Aabb> boxes)
{
    for (std::size_t k = 0; k < boxes.size(); ++k) refuse_unusable(boxes[k], "query", k);
}

void refuse_unusable_queries(std::span<const Segment> segments)
{
    for (std::size_t k = 0; k < segments.size(); ++k) {
        Aabb box; // keeps NaN, unlike cwiseMin()
        box.min = segments[k].from, box.max = segments[k].to;
        refuse_unusable(box, "query", k);
    }
}

} // namespace oncollide
