// Worlds, their models, their steps.
#include "world.hpp"
#include "call.hpp"
#include "geometry.hpp"

#include <nlohmann/json.hpp>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/settings_table.hpp>

using namespace oncollide;
using namespace oncollide::web;

namespace {

/// Settings from a JSON object whose keys are the members' names.
Settings settings_of(const char* json)
{
    Settings made;
    const nlohmann::json given = nlohmann::json::parse(json);
    for (const auto& [key, value] : given.items()) {
        const SettingRow* const row = setting_of(key);
        if (!row) {
            std::string names;
            for (const SettingRow& r : settings_table()) names += (names.empty() ? "" : ", ") + std::string(r.member);
            throw Error(ErrorKind::usage, "World: no setting '" + printable(key) + "'; valid: " + names);
        }
        try {
            row->set(made, value);
        } catch (const nlohmann::json::exception&) {
            throw Error(ErrorKind::usage, "World: " + std::string(row->member) + ": " + value.dump() +
                                              " is a value of another type; by default: " + row->get(Settings()));
        }
        row->check(made);
    }
    return made;
}

void put(Results& to, std::span<const PairOfBodies> pairs)
{
    ColumnWriter rows(to, pairs.size(), 2);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        rows.next(i, number_of(pairs[i].a)), rows.next(i, number_of(pairs[i].b));
        rows.end_row();
    }
}

std::vector<Eigen::Vector3d> positions_at(const double* numbers, std::size_t count)
{
    std::vector<Eigen::Vector3d> positions(count);
    for (std::size_t i = 0; i < count; ++i) positions[i] = Eigen::Map<const Eigen::Vector3d>(numbers + 3 * i);
    return positions;
}

const FrameView& frame_of(const HeldWorld& held)
{
    if (!held.frame) throw Error(ErrorKind::usage, "the World has had no step yet; call step()");
    return *held.frame;
}

} // namespace

ONCOLLIDE_WEB int oc_world(const char* settings, HeldWorld** made)
{
    return call([=] { *made = new HeldWorld{.world = World(settings_of(settings))}; });
}
ONCOLLIDE_WEB void oc_world_free(HeldWorld* held)
{
    delete held;
}
/// The settings as JSON, kept where messages of errors are.
ONCOLLIDE_WEB int oc_world_settings(const HeldWorld* held, char* text, std::size_t size)
{
    return call([=] {
        std::string json = "{";
        for (const SettingRow& row : settings_table())
            json +=
                (json.size() > 1 ? ",\"" : "\"") + std::string(row.member) + "\":" + row.get(held->world.settings());
        json += "}";
        if (json.size() >= size) throw Error(ErrorKind::internal, "the settings are too long");
        json.copy(text, json.size());
        text[json.size()] = '\0';
    });
}
/// Bodies, models, frames, bytes, and the two halves of the hash.
ONCOLLIDE_WEB int oc_world_info(const HeldWorld* held)
{
    return call([=] {
        const WorldInfo info = held->world.inspect();
        const std::uint64_t hash = held->world.hash();
        ColumnWriter row(results(), 1, 6);
        row.next(0, double(info.bodies)), row.next(0, double(info.models)), row.next(0, double(info.frames));
        row.next(0, double(info.bytes));
        row.next(0, double(hash & 0xffffffff)), row.next(0, double(hash >> 32));
    });
}

// --- Models.

ONCOLLIDE_WEB int oc_models_add(HeldWorld* held, const HeldGeometry* geometry, double* id)
{
    return call([=] {
        const ModelId made = held->world.models().add(geometry->geometry);
        held->tag = made.world;
        *id = number_of(made);
    });
}
ONCOLLIDE_WEB int oc_models_replace(HeldWorld* held, double model, const HeldGeometry* geometry)
{
    return call([=] { held->world.models().replace(held->model(model), geometry->geometry); });
}
ONCOLLIDE_WEB int oc_models_remove(HeldWorld* held, double model)
{
    return call([=] { held->world.models().remove(held->model(model)); });
}
ONCOLLIDE_WEB int oc_models_set_vertices(HeldWorld* held, double model, double first, const double* positions,
                                         std::size_t count)
{
    return call([=] {
        const std::vector<Eigen::Vector3d> moved = positions_at(positions, count);
        if (first < 0)
            held->world.models().set_vertices(held->model(model), moved);
        else
            held->world.models().set_vertices(held->model(model), static_cast<std::size_t>(first), moved);
    });
}
ONCOLLIDE_WEB int oc_models_closed(const HeldWorld* held, double model, int* closed)
{
    return call([=] { *closed = held->world.models().closed(held->model(model)); });
}
ONCOLLIDE_WEB int oc_models_contains(const HeldWorld* held, double model)
{
    return held->world.models().contains(held->model(model));
}
ONCOLLIDE_WEB int oc_models_self_contacts(const HeldWorld* held, double model, double most)
{
    return call([=] {
        const std::size_t limit =
            most >= 0 && most < 0x1p31 ? static_cast<std::size_t>(most) : std::numeric_limits<std::size_t>::max();
        const auto pairs = held->world.models().self_contacts(held->model(model), limit);
        ColumnWriter rows(results(), pairs.size(), 2);
        for (std::size_t i = 0; i < pairs.size(); ++i)
            rows.next(i, pairs[i].a), rows.next(i, pairs[i].b), rows.end_row();
    });
}
ONCOLLIDE_WEB int oc_models_bounds(const HeldWorld* held, double model, const double* pose)
{
    return call([=] {
        const Aabb bounds = held->world.models().bounds(held->model(model), RigidMotion(pose_at(pose, 0)));
        ColumnWriter row(results(), 1, 6);
        row.next(0, bounds.min), row.next(0, bounds.max);
    });
}

// --- Frames.

/// Number of the frame, milliseconds, the two halves of its hash, its numbers
/// of pairs, of pairs that began, of pairs that ended, and of sweeps; pairs of cells or boxes and of triangles that
/// were tested, nodes stored, and their bytes.
ONCOLLIDE_WEB int oc_step(HeldWorld* held)
{
    return call([=] {
        held->frame.reset();
        held->frame.emplace(held->world.step());
        const FrameView& frame = *held->frame;
        ColumnWriter row(results(), 1, 12);
        for (const double number :
             {double(frame.frame), frame.ms, double(frame.hash & 0xffffffff), double(frame.hash >> 32),
              double(frame.pairs.size()), double(frame.began.size()), double(frame.ended.size()),
              double(frame.sweeps.size()), double(frame.trees.node_pairs), double(frame.trees.triangle_pairs),
              double(frame.trees.nodes), double(frame.trees.bytes)})
            row.next(0, number);
    });
}
/// a, b, verdict, kind, stage, bound of each pair; with `met`, of the pairs that are not separate.
ONCOLLIDE_WEB int oc_frame_pairs(const HeldWorld* held, bool met)
{
    return call([=] {
        const auto& pairs = frame_of(*held).pairs;
        const auto wanted = [met](const PairResult& p) { return !met || p.verdict != Verdict::separate; };
        std::size_t count = 0, i = 0;
        for (const PairResult& pair : pairs) count += wanted(pair);
        ColumnWriter rows(results(), count, 6);
        for (const PairResult& pair : pairs) {
            if (!wanted(pair)) continue;
            rows.next(i, number_of(pair.a)), rows.next(i, number_of(pair.b));
            rows.next(i, static_cast<double>(pair.verdict)), rows.next(i, static_cast<double>(pair.kind));
            rows.next(i, static_cast<double>(pair.stage)), rows.next(i, pair.bound);
            rows.end_row(), ++i;
        }
    });
}
ONCOLLIDE_WEB int oc_frame_changes(const HeldWorld* held, bool ended)
{
    return call([=] { put(results(), ended ? frame_of(*held).ended : frame_of(*held).began); });
}
