#include <oncollide/broadphase/tree/loose_aabbs.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>

namespace oncollide {

LooseAabbs::Row LooseAabbs::row(std::uint32_t body, const BodyColumns& columns, bool dynamic)
{
    const auto of = [&](std::span<const std::uint32_t> column) { return column.empty() ? 0 : column[body]; };
    return {columns.boxes[body], of(columns.layers), of(columns.masks), of(columns.groups), dynamic, 0};
}

bool LooseAabbs::hold(std::uint32_t body, const BodyColumns& columns, bool dynamic, bool filters_too) const
{
    ONCOLLIDE_ASSERT(body < columns.boxes.size());
    if (body >= row_of_.size() || row_of_[body] == none) return false;
    const Row& loose = rows_[row_of_[body]];
    if (!loose.box.contains(columns.boxes[body]) || loose.dynamic != dynamic) return false;
    if (!filters_too) return true;
    const Row now = row(body, columns, dynamic);
    return loose.layers == now.layers && loose.mask == now.mask && loose.group == now.group;
}

Aabb LooseAabbs::renew(std::uint32_t body, const BodyColumns& columns, bool dynamic)
{
    ONCOLLIDE_ASSERT(body < columns.boxes.size() && usable(columns.boxes[body]));
    if (body >= row_of_.size()) row_of_.resize(columns.boxes.size(), none);
    std::uint32_t& number = row_of_[body];
    const bool known = number != none;
    if (!known && free_.empty()) {
        number = static_cast<std::uint32_t>(rows_.size());
        rows_.emplace_back(), owners_.push_back(body);
    } else if (!known) {
        number = free_.back();
        free_.pop_back();
        owners_[number] = body;
    }
    const std::uint32_t frames = 3 + (body * 2654435769u >> 30); // 3 to 6, so that not all bodies escape in the same
                                                                 // frame
    Row& loose = rows_[number];
    const Row before = loose;
    loose = row(body, columns, dynamic);
    loose.made = frame_;
    if (!known) return loose.box;
    const std::uint32_t since = (frame_ - before.made) & 0x7fffffffu; // modulo the width of `made`
    const double moved = (loose.box.centre() - before.box.centre()).cwiseAbs().maxCoeff();
    const double step = moved / std::max(1u, since), half = (loose.box.max - loose.box.min).sum() / 6;
    const Eigen::Vector3d room = Eigen::Vector3d::Constant(std::min(frames * step, half));
    const Aabb larger{loose.box.min - room, loose.box.max + room};
    if (2 * step < half && usable(larger)) loose.box = larger;
    ONCOLLIDE_ASSERT(loose.box.contains(columns.boxes[body]));
    return loose.box;
}

void LooseAabbs::erase(std::uint32_t body)
{
    if (body >= row_of_.size() || row_of_[body] == none) return;
    owners_[row_of_[body]] = none;
    free_.push_back(row_of_[body]);
    row_of_[body] = none;
}

void LooseAabbs::clear()
{
    for (std::uint32_t body : owners_)
        if (body != none) row_of_[body] = none;
    rows_.clear(), owners_.clear(), free_.clear();
}

std::string LooseAabbs::validate(const BodyColumns& columns) const
{
    std::size_t owned = 0;
    for (std::uint32_t body = 0; body < row_of_.size(); ++body) {
        const std::uint32_t row = row_of_[body];
        if (row == none) continue;
        ++owned;
        if (row >= rows_.size() || owners_[row] != body)
            return fmt::format("body {} uses row {} of another", body, row);
        if (!rows_[row].box.contains(columns.boxes[body])) return fmt::format("body {} is outside its box", body);
    }
    if (owners_.size() != rows_.size() || owned + free_.size() != rows_.size())
        return fmt::format("{} rows for {} bodies and {} free rows", rows_.size(), owned, free_.size());
    // If the sums of hashes are equal, each free row is listed once. This allocates nothing.
    std::uint64_t listed = 0, unused = 0;
    for (std::uint32_t row : free_) listed += splitmix(row);
    for (std::uint32_t row = 0; row < rows_.size(); ++row)
        if (owners_[row] == none) unused += splitmix(row);
    return listed == unused ? "" : "the list of free rows is not the rows without a body";
}

std::size_t LooseAabbs::bytes() const
{
    return (row_of_.capacity() + owners_.capacity() + free_.capacity()) * sizeof(std::uint32_t) +
           rows_.capacity() * sizeof(Row);
}

} // namespace oncollide
