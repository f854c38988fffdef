#include <oncollide/narrowphase/gl/list_store.hpp>

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include <oncollide/narrowphase/gl/octant_shaders.hpp>

namespace oncollide::gl {

namespace {

constexpr GLuint most_groups = 65535; // the minimum that every driver must allow

std::uint32_t number(ListId list)
{
    return static_cast<std::uint32_t>(list);
}

} // namespace

void grow(Buffer& buffer, std::size_t bytes, std::size_t kept, std::size_t most, const char* what, GLbitfield flags)
{
    if (buffer.bytes() >= bytes) return;
    if (bytes > most)
        throw GpuLost(fmt::format("{} need {:.1f} MB, but a buffer may hold {:.1f} MB", what, double(bytes) / 1e6,
                                  double(most) / 1e6));
    Buffer larger(std::min(std::bit_ceil(bytes), most), flags);
    if (kept) glCopyNamedBufferSubData(buffer.name(), larger.name(), 0, 0, static_cast<GLsizeiptr>(kept));
    buffer = std::move(larger);
}

ListStore::ListStore(std::size_t most_bytes, std::size_t first_entries)
    : most_(most_bytes), entries_(4 * std::max<std::size_t>(first_entries, 64), 0), lists_(4 * words::list * 1024, 0),
      counters_(16, GL_DYNAMIC_STORAGE_BIT), pack_("packing of lists", {{GL_COMPUTE_SHADER, OctantShaders::pack()}}),
      read_("reading of lists", {{GL_COMPUTE_SHADER, OctantShaders::read()}})
{
}

ListId ListStore::add()
{
    std::uint32_t list = static_cast<std::uint32_t>(lists_in_use_.size());
    if (free_.empty())
        lists_in_use_.push_back(true);
    else
        list = free_.back(), free_.pop_back(), lists_in_use_[list] = true;
    return fresh_.emplace_back(ListId{list});
}

void ListStore::release(ListId list)
{
    if (list == all_triangles) return;
    lists_in_use_[number(list)] = false;
    free_.push_back(number(list));
    holes_ = true;
    if (free_.size() == lists_in_use_.size()) used_ = 0, holes_ = false; // no lists are left
}

void ListStore::make_list_room()
{
    grow(lists_, 4 * words::list * lists_in_use_.size(), lists_.bytes(), most_, "triangle lists");
}

void ListStore::bind() const
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding::entries, entries_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding::lists, lists_.name());
}

/// One group per job of two words. Leaves the number of entries in counters_[1].
void ListStore::run_jobs(const Program& program, std::span<const std::uint32_t> jobs, const Buffer& target)
{
    grow(jobs_, jobs.size_bytes(), 0, most_, "lists to copy", GL_DYNAMIC_STORAGE_BIT);
    glNamedBufferSubData(jobs_.name(), 0, static_cast<GLsizeiptr>(jobs.size_bytes()), jobs.data());
    const std::uint32_t zero[4]{};
    glNamedBufferSubData(counters_.name(), 0, sizeof zero, zero);
    bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding::packed, target.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding::jobs, jobs_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding::out, counters_.name());
    glUseProgram(program.name());
    const auto count = static_cast<GLuint>(jobs.size() / 2);
    glUniform1ui(0, count);
    glUniform1ui(2, static_cast<GLuint>(target.bytes() / 4));
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    glDispatchCompute(std::min(count, most_groups), 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void ListStore::pack()
{
    std::vector<std::uint32_t> jobs;
    std::vector<bool> whole = lists_in_use_;
    for (ListId list : fresh_) whole[number(list)] = false;
    for (std::uint32_t list = 0; list < whole.size(); ++list)
        if (whole[list]) jobs.insert(jobs.end(), {list, 0});
    Buffer packed(entries_.bytes(), 0);
    run_jobs(pack_, jobs, packed);
    std::uint32_t counters[4];
    glGetNamedBufferSubData(counters_.name(), 0, sizeof counters, counters);
    ONCOLLIDE_ASSERT(counters[1] <= used_);
    entries_ = std::move(packed);
    used_ = counters[1], holes_ = false;
}

void ListStore::make_entry_room(std::size_t count)
{
    if (used_ + count <= entry_room()) return;
    if (holes_) pack();
    // Packing repeatedly for a few entries would cost more than memory.
    const std::size_t wanted = used_ + count;
    if (4 * wanted > 3 * entry_room())
        grow(entries_, std::max(4 * wanted, std::min(8 * wanted, most_)), 4 * used_, most_, "triangle lists");
}

void ListStore::read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
                     std::vector<std::size_t>& ends)
{
    if (reads.empty()) return;
    std::vector<std::uint32_t> jobs;
    for (const ListRead& r : reads) jobs.insert(jobs.end(), {number(r.list), r.octant});
    std::uint32_t counters[4];
    for (std::size_t room = 4096;; room = counters[1]) {
        grow(packed_, 4 * room, 0, most_, "triangles to read");
        run_jobs(read_, jobs, packed_);
        glGetNamedBufferSubData(counters_.name(), 0, sizeof counters, counters);
        if (4 * std::size_t(counters[1]) <= packed_.bytes()) break;
    }
    std::vector<std::uint32_t> all(counters[1]);
    glGetNamedBufferSubData(jobs_.name(), 0, static_cast<GLsizeiptr>(4 * jobs.size()), jobs.data());
    if (!all.empty()) glGetNamedBufferSubData(packed_.name(), 0, static_cast<GLsizeiptr>(4 * all.size()), all.data());
    for (std::size_t i = 0; i < reads.size(); ++i) { // positions depend on the order of the groups
        const auto from = all.begin() + jobs[2 * i];
        const auto begin = static_cast<std::ptrdiff_t>(triangles.size());
        triangles.insert(triangles.end(), from, from + jobs[2 * i + 1]);
        std::sort(triangles.begin() + begin, triangles.end());
        ends.push_back(triangles.size());
    }
}

} // namespace oncollide::gl
