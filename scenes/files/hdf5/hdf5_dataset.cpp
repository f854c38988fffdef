#include <oncollide/scenes/files/hdf5/hdf5_dataset.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <oncollide/scenes/files/hdf5/hdf5_filters.hpp>

namespace oncollide {

namespace {

using LayoutKind = Hdf5Layout::Kind;

constexpr std::uint64_t most_chunk_bytes = std::uint64_t{256} << 20;

/// Throws if the product is above `most`.
std::uint64_t product(std::span<const std::uint64_t> factors, std::uint64_t first, std::uint64_t most,
                      const std::string& fault)
{
    std::uint64_t all = first;
    for (const std::uint64_t factor : factors) {
        if (factor > 0 && all > most / factor) throw Hdf5Fault{fault};
        all *= factor;
    }
    return all;
}

Hdf5Block type_of(Hdf5Walk& walk, const Hdf5Object& object)
{
    const Hdf5Message* const type = object.find(Hdf5MessageType::datatype);
    if (!type || !object.find(Hdf5MessageType::layout)) throw Hdf5Fault{"is not a dataset"};
    return hdf5_content(walk, *type);
}

} // namespace

Hdf5Dataset::Hdf5Dataset(std::shared_ptr<const Hdf5Bytes> file, const Hdf5Object& object) : file_(std::move(file))
{
    Hdf5Walk walk(*file_);
    type_ = hdf5_type(type_of(walk, object).cursor(*file_));
    layout_ = hdf5_layout(walk, object), space_ = hdf5_space(walk, object);
    if (type_.kind == Hdf5Type::Kind::other) throw Hdf5Fault{hdf5_other_type};
    fill_ = hdf5_fill_value(walk, object, type_.size);
    if (layout_.kind == LayoutKind::compact || layout_.kind == LayoutKind::contiguous)
        place_contiguous(object);
    else if (layout_.edges.size() != space_.extent.size() || layout_.value_bytes != type_.size)
        hdf5_damaged(object.address(), "chunks have another shape than the dataset");
    chunk_bytes_ = product(layout_.edges, type_.size, most_chunk_bytes,
                           fmt::format("its chunks are larger than {} bytes", most_chunk_bytes));
    grid_ = std::make_unique<Hdf5Grid>(space_.extent, layout_.edges);
    chunks_ = hdf5_chunks(walk, layout_, space_, *grid_, chunk_bytes_);
    std::uint64_t side_by_side = 1;
    for (std::size_t d = 1; d < grid_->dimensions() && layout_.edges[0] > 1; ++d)
        side_by_side *= std::max<std::uint64_t>(1, grid_->count(d));
    slots_.resize(
        std::clamp<std::uint64_t>(std::min(side_by_side, chunks_.size()), 1, most_chunk_bytes / chunk_bytes_));
}

/// Cuts the data into chunks that are in one piece each.
void Hdf5Dataset::place_contiguous(const Hdf5Object& object)
{
    constexpr std::uint64_t piece_bytes = std::uint64_t{1} << 20;
    const std::uint64_t bytes = product(space_.extent, type_.size, std::uint64_t{1} << 62, "has an impossible size");
    const bool is_short = layout_.kind == LayoutKind::compact
                              ? bytes > layout_.data.size()
                              : layout_.address != hdf5_nowhere &&
                                    (layout_.address > file_->size() || bytes > file_->size() - layout_.address);
    if (is_short) hdf5_damaged(object.address(), "the file is too short for a dataset");
    layout_.edges.assign(space_.extent.size(), 1);
    std::uint64_t values = std::max<std::uint64_t>(1, piece_bytes / type_.size);
    for (std::size_t d = space_.extent.size(); d-- > 0 && values > 1;) {
        const std::uint64_t edge = std::clamp<std::uint64_t>(space_.extent[d], 1, values);
        layout_.edges[d] = edge;
        values = edge == space_.extent[d] ? values / edge : 1;
    }
}

std::uint64_t Hdf5Dataset::rows_in_file() const
{
    if (space_.extent.empty()) return 0;
    if (layout_.kind == LayoutKind::compact || layout_.kind == LayoutKind::contiguous)
        return layout_.kind == LayoutKind::compact || layout_.address != hdf5_nowhere ? space_.extent[0] : 0;
    const std::uint64_t rows = layout_.edges[0];
    return chunks_.size() > hdf5_nowhere / rows ? hdf5_nowhere : chunks_.size() * rows;
}

void Hdf5Dataset::read_contiguous(std::span<const std::uint64_t> chunk, std::string& out) const
{
    std::uint64_t first = 0, values = 1;
    for (std::size_t d = 0; d < chunk.size(); ++d) {
        const std::uint64_t begin = chunk[d] * layout_.edges[d];
        first = first * space_.extent[d] + begin;
        values *= std::min(layout_.edges[d], space_.extent[d] - begin);
    }
    out.resize(values * type_.size);
    if (layout_.kind == LayoutKind::compact)
        layout_.data.copy(out.data(), out.size(), first * type_.size);
    else
        file_->read(layout_.address + first * type_.size, out.size(), out.data());
}

void Hdf5Dataset::read_chunk(const Hdf5Chunk& chunk, bool is_part, std::string& out) const
{
    const bool plain = layout_.filters.empty() || (is_part && layout_.parts_are_unfiltered);
    if (plain && chunk.bytes != chunk_bytes_) hdf5_damaged(chunk.address, "a chunk has an impossible size");
    std::string& stored = plain ? out : stored_;
    if (chunk.bytes > file_->size()) hdf5_damaged(chunk.address, "the file ends");
    stored.resize(chunk.bytes);
    file_->read(chunk.address, stored.size(), stored.data());
    if (!plain) undo_hdf5_filters(layout_.filters, chunk.skipped, stored_, out, chunk_bytes_);
}

const char* Hdf5Dataset::load(std::uint64_t number, std::span<const std::uint64_t> chunk) const
{
    Slot& slot = slots_[number % slots_.size()];
    if (slot.number == number) return slot.bytes.data();
    if (layout_.kind == LayoutKind::compact || layout_.kind == LayoutKind::contiguous) {
        if (layout_.kind == LayoutKind::contiguous && layout_.address == hdf5_nowhere) return nullptr;
        slot.number = hdf5_nowhere, read_contiguous(chunk, slot.bytes), slot.number = number;
        return slot.bytes.data();
    }
    const auto found = std::ranges::lower_bound(chunks_, number, {}, &Hdf5Chunk::number);
    if (found == chunks_.end() || found->number != number) return nullptr;
    bool is_part = false;
    for (std::size_t d = 0; d < chunk.size(); ++d)
        is_part |= space_.extent[d] - chunk[d] * layout_.edges[d] < layout_.edges[d];
    slot.number = hdf5_nowhere, read_chunk(*found, is_part, slot.bytes), slot.number = number;
    return slot.bytes.data();
}

/// Passes on the values that a chunk has in common with the wanted part.
void Hdf5Dataset::give(std::span<const std::uint64_t> chunk, std::span<const std::uint64_t> start,
                       std::span<const std::uint64_t> count, FunctionRef<void(const Hdf5Piece&)> take) const
{
    const std::size_t n = chunk.size();
    std::array<std::uint64_t, hdf5_most_dimensions> in_chunk, in_result, size, step, result_step, at;
    const char* const bytes = load(grid_->number(chunk), chunk);
    step[n - 1] = result_step[n - 1] = 1;
    for (std::size_t d = n; d-- > 0;) {
        const std::uint64_t first = chunk[d] * layout_.edges[d], begin = std::max(first, start[d]),
                            end = first + std::min(layout_.edges[d], start[d] + count[d] - first);
        in_chunk[d] = begin - first, in_result[d] = begin - start[d], size[d] = end - begin, at[d] = 0;
        if (d + 1 < n) step[d] = step[d + 1] * layout_.edges[d + 1], result_step[d] = result_step[d + 1] * count[d + 1];
    }
    std::size_t inner = n - 1; // dimensions from here on are one run in the chunk and in the result
    std::uint64_t run = size[inner];
    for (; inner > 0 && size[inner] == layout_.edges[inner] && size[inner] == count[inner]; --inner)
        run *= size[inner - 1];
    Hdf5Piece piece{bytes ? bytes : fill_.data(), 1, run, 0, bytes ? type_.size : 0, 0, 0};
    const std::size_t outer = inner > 0 ? inner - 1 : 0; // loops run over the dimensions before it
    if (inner > 0)
        piece.rows = size[outer], piece.to_row = result_step[outer], piece.row_bytes = step[outer] * piece.value_bytes;
    for (bool more = true; more;) {
        std::uint64_t from = 0;
        piece.to = 0;
        for (std::size_t d = 0; d < n; ++d)
            from += (in_chunk[d] + at[d]) * step[d], piece.to += (in_result[d] + at[d]) * result_step[d];
        piece.from = (bytes ? bytes : fill_.data()) + from * piece.value_bytes;
        take(piece);
        more = false;
        for (std::size_t d = outer; d-- > 0 && !more; at[d] = more ? at[d] : 0) more = ++at[d] < size[d];
    }
}

void Hdf5Dataset::read(std::span<const std::uint64_t> start, std::span<const std::uint64_t> count,
                       FunctionRef<void(const Hdf5Piece&)> take) const
{
    const std::size_t n = start.size();
    if (n == 0 || std::ranges::count(count, 0u)) return;
    std::vector<std::uint64_t> chunk(n);
    for (std::size_t d = 0; d < n; ++d) chunk[d] = start[d] / layout_.edges[d];
    for (bool more = true; more;) {
        give(chunk, start, count, take);
        more = false;
        for (std::size_t d = n; d-- > 0 && !more;) {
            more = ++chunk[d] <= (start[d] + count[d] - 1) / layout_.edges[d];
            if (!more) chunk[d] = start[d] / layout_.edges[d];
        }
    }
}

} // namespace oncollide
