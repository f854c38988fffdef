#include <oncollide/pipeline/world/body_table.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>

namespace oncollide {

void BodyChanges::clear()
{
    for (auto* list : {&removed, &added_dynamic, &added_static, &moved, &made_static, &made_dynamic, &fresh})
        list->clear();
}

bool BodyChanges::empty() const
{
    for (const auto* list : {&removed, &added_dynamic, &added_static, &moved, &made_static, &made_dynamic, &fresh})
        if (!list->empty()) return false;
    return true;
}

void BodyTable::mark(std::uint32_t slot, std::uint8_t how)
{
    if (!(state_[slot] & listed_bit)) changed_.push_back(slot);
    if (how & (fresh_bit | moved_bit)) set_asleep(slot, false);
    state_[slot] |= static_cast<std::uint8_t>(how | listed_bit);
}

void BodyTable::reserve(std::size_t slots)
{
    state_.reserve(slots), reserve_large(model_of_, slots), reserve_large(poses_, slots);
    for (auto* column : {&layers_, &masks_, &groups_, &changed_}) reserve_large(*column, slots);
    reserve_large(travel_, slots), reserve_large(stretch_, slots), reserve_large(boxes_, slots);
}

void BodyTable::note_model(std::uint32_t slot, Model* model, ModelId id)
{
    if (models_.size() <= id.slot) models_.resize(id.slot + std::size_t{1});
    models_[id.slot] = {model, id};
    model_of_[slot] = id.slot;
}

void BodyTable::set_user(std::uint32_t slot, std::uint64_t user)
{
    if (user_.size() <= slot) user_.resize(slots());
    user_[slot] = user;
}

std::uint32_t BodyTable::add(const Init& body)
{
    std::uint32_t slot;
    if (free_.empty()) {
        slot = slots();
        state_.push_back(0), model_of_.push_back(0);
        poses_.emplace_back(), layers_.push_back(0), masks_.push_back(0), groups_.push_back(0);
        boxes_.emplace_back(), travel_.push_back(0), stretch_.push_back(0);
    } else {
        slot = free_.back();
        free_.pop_back();
    }
    note_model(slot, body.model, body.model_id), poses_[slot] = body.pose,
                                                 stretch_[slot] = oncollide::stretch(body.pose);
    layers_[slot] = body.layer, masks_[slot] = body.mask, groups_[slot] = body.group;
    ++filters_version_;
    if (body.user || user(slot)) set_user(slot, body.user);
    any_group_ |= body.group != 0;
    state_[slot] =
        static_cast<std::uint8_t>((state_[slot] & ~static_bit) | alive_bit | (body.is_static ? static_bit : 0));
    ++size_, dynamic_ += !body.is_static;
    mark(slot, fresh_bit);
    return slot;
}

void BodyTable::remove(std::uint32_t slot)
{
    --size_, dynamic_ -= !is_static(slot);
    if (motion(slot)) motion_of_[slot] = 0;
    state_[slot] = static_cast<std::uint8_t>(state_[slot] & ~(alive_bit | static_bit));
    if (removed_.size() <= slot) removed_.resize(slots());
    if (const auto found = partners_.find(slot); found != partners_.end()) {
        for (std::uint32_t other : found->second) excluded_.erase(key(slot, other));
        partners_.erase(found);
    }
    if (++removed_[slot] < last_generation) free_.push_back(slot);
    mark(slot, fresh_bit);
}

void BodyTable::set_motion(std::uint32_t slot, RigidMotion motion)
{
    const double travel = (travel_[slot] + model(slot).bounds().motion(poses_[slot], motion)) * (1 + 0x1p-52);
    set_pose(slot, motion.pose(1));
    if (motion.rests()) return;
    travel_[slot] = std::max(travel_[slot], travel);
    if (motion_of_.size() <= slot) motion_of_.resize(slots());
    motions_.push_back(std::move(motion)), moving_.push_back(slot);
    motion_of_[slot] = static_cast<std::uint32_t>(motions_.size());
    mark(slot, moved_bit);
}

void BodyTable::end_motions()
{
    for (const std::uint32_t slot : moving_) {
        motion_of_[slot] = 0;
        if (alive(slot)) mark(slot, moved_bit);
    }
    motions_.clear(), moving_.clear();
}

void BodyTable::set_pose(std::uint32_t slot, const Eigen::Isometry3d& pose)
{
    if (motion(slot)) motion_of_[slot] = 0, mark(slot, moved_bit);
    if (poses_[slot].matrix() == pose.matrix()) return; // so resting bodies cost no work later
    // Rounded up, so that a difference of two travels is never less than the motion between them.
    travel_[slot] = (travel_[slot] + model(slot).bounds().motion(poses_[slot], pose)) * (1 + 0x1p-52);
    poses_[slot] = pose, stretch_[slot] = oncollide::stretch(pose);
    mark(slot, moved_bit);
}

void BodyTable::set_filter(std::uint32_t slot, std::uint32_t layer, std::uint32_t mask, std::uint32_t group)
{
    if (layers_[slot] == layer && masks_[slot] == mask && groups_[slot] == group) return;
    layers_[slot] = layer, masks_[slot] = mask, groups_[slot] = group;
    ++filters_version_;
    any_group_ |= group != 0;
    mark(slot, moved_bit);
}

void BodyTable::set_static(std::uint32_t slot, bool now)
{
    if (is_static(slot) == now) return;
    state_[slot] ^= static_bit;
    now ? --dynamic_ : ++dynamic_;
    mark(slot, 0);
}

void BodyTable::set_asleep(std::uint32_t slot, bool asleep)
{
    state_[slot] = static_cast<std::uint8_t>(asleep ? state_[slot] | asleep_bit : state_[slot] & ~asleep_bit);
}

void BodyTable::set_model(std::uint32_t slot, Model* model, ModelId id)
{
    note_model(slot, model, id);
    mark(slot, fresh_bit);
}

void BodyTable::deform(std::uint32_t slot, double moved)
{
    constexpr double rigid = 0x1p-18; // poses may be 2^-20 from rigid
    travel_[slot] = (travel_[slot] + moved * (1 + rigid)) * (1 + 0x1p-52);
    mark(slot, moved_bit);
}

void BodyTable::exclude(std::uint32_t a, std::uint32_t b)
{
    if (!excluded_.insert(key(a, b)).second) return;
    ++exclusions_version_;
    partners_[a].push_back(b), partners_[b].push_back(a);
}

void BodyTable::include(std::uint32_t a, std::uint32_t b)
{
    if (excluded_.erase(key(a, b)) == 0) return;
    ++exclusions_version_;
    std::erase(partners_[a], b), std::erase(partners_[b], a);
}

void BodyTable::take_changes(BodyChanges& changes)
{
    changes.clear();
    for (std::uint32_t slot : changed_) {
        const std::uint8_t state = state_[slot];
        const bool alive = state & alive_bit, is_static = state & static_bit, known = state & known_bit,
                   fresh = state & fresh_bit, was_static = state & known_static_bit;
        if (fresh) changes.fresh.push_back(slot);
        if (known && (!alive || fresh)) changes.removed.push_back(slot);
        if (alive && (!known || fresh))
            (is_static ? changes.added_static : changes.added_dynamic).push_back(slot);
        else if (alive) {
            if (state & moved_bit) changes.moved.push_back(slot);
            if (is_static != was_static) (is_static ? changes.made_static : changes.made_dynamic).push_back(slot);
        }
        state_[slot] = static_cast<std::uint8_t>(!alive ? 0
                                                        : alive_bit | known_bit | (state & asleep_bit) |
                                                              (is_static ? static_bit | known_static_bit : 0));
    }
    changed_.clear();
}

void update_boxes(BodyTable& bodies, const BodyChanges& changes, bool tight, int threads)
{
    constexpr std::size_t ahead = 8;
    for (const auto* list : {&changes.added_static, &changes.added_dynamic, &changes.moved}) {
        const auto prefetch = [&](std::size_t i) {
            if (i + ahead < list->size()) bodies.prefetch((*list)[i + ahead]);
        };
        for (std::size_t i = 0; tight && i < list->size(); ++i) {
            if (i + ahead < list->size()) bodies.prefetch_model((*list)[i + ahead]);
            PoseBounds& bounds = bodies.model((*list)[i]).bounds();
            if (!bounds.prepares()) continue;
            const RigidMotion* const motion = bodies.motion((*list)[i]);
            motion ? bounds.expect(*motion) : bounds.expect(bodies.pose((*list)[i]));
        }
        parallel_chunks(list->size(), 2048, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t slot = (*list)[i];
                prefetch(i);
                const PoseBounds& bounds = bodies.model(slot).bounds();
                if (const RigidMotion* const motion = bodies.motion(slot))
                    bodies.boxes()[slot] = bounds.box(*motion, tight);
                else
                    bodies.boxes()[slot] = tight ? bounds.box(bodies.pose(slot)) : bounds.sphere_box(bodies.pose(slot));
            }
        });
    }
}

std::string BodyTable::validate() const
{
    for (const std::size_t rows : {model_of_.size(), poses_.size(), layers_.size(), masks_.size(), groups_.size(),
                                   travel_.size(), stretch_.size(), boxes_.size()})
        if (rows != slots()) return fmt::format("a column has {} rows for {} slots", rows, slots());
    std::uint32_t bodies = 0, dynamic = 0;
    std::size_t listed = 0, retired = 0;
    std::uint64_t unused = 0; // sum of hashes: compared with the list of free slots without allocating
    for (std::uint32_t slot = 0; slot < slots(); ++slot) {
        const std::uint8_t state = state_[slot];
        listed += bool(state & listed_bit);
        if (!(state & alive_bit)) {
            const bool spent = slot < removed_.size() && removed_[slot] >= last_generation;
            retired += spent, unused += spent ? 0 : splitmix(slot);
            if (state & static_bit) return fmt::format("slot {} is free, but static", slot);
            continue;
        }
        ++bodies, dynamic += !(state & static_bit);
        if (model_of_[slot] >= models_.size() || !models_[model_of_[slot]].model)
            return fmt::format("body {} has no model", slot);
        if (!(travel_[slot] >= 0)) return fmt::format("body {} has travelled {} m", slot, travel_[slot]);
        if (state & known_bit && !(state & (fresh_bit | moved_bit)) && boxes_[slot].empty())
            return fmt::format("body {} has an empty AABB", slot);
    }
    if (bodies != size_ || dynamic != dynamic_)
        return fmt::format("counts {} bodies, {} dynamic; there are {} and {}", size_, dynamic_, bodies, dynamic);
    for (std::uint32_t slot : free_) unused -= splitmix(slot);
    if (unused != 0 || bodies + free_.size() + retired != slots())
        return "the list of free slots is not the free slots";
    if (listed != changed_.size()) return fmt::format("{} bodies changed, {} are listed", listed, changed_.size());
    for (const std::uint64_t pair : excluded_)
        if (!alive(static_cast<std::uint32_t>(pair >> 32)) || !alive(static_cast<std::uint32_t>(pair)))
            return fmt::format("the excluded pair ({}, {}) is not of two bodies", pair >> 32, pair & ~0u);
    return {};
}

std::size_t BodyTable::bytes() const
{
    return state_.capacity() + removed_.capacity() * sizeof(std::uint16_t) +
           (layers_.capacity() + masks_.capacity() + groups_.capacity() + free_.capacity() + changed_.capacity() +
            model_of_.capacity()) *
               sizeof(std::uint32_t) +
           poses_.capacity() * sizeof(Eigen::Isometry3d) +
           (user_.capacity() + travel_.capacity() + stretch_.capacity()) * sizeof(std::uint64_t) +
           boxes_.capacity() * sizeof(Aabb) + excluded_.size() * 40 + 2 * excluded_.size() * sizeof(std::uint32_t);
}

} // namespace oncollide
