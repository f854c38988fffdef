// MuJoCo: a model of two geoms that rest, compiled from XML, and its contacts. It takes hulls for collisions, so that a
// mesh is queried only for rays.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "common.hpp"

namespace {

std::string text_of(std::initializer_list<double> numbers)
{
    std::string text;
    for (const double x : numbers) {
        char digits[32];
        text.append(digits, std::to_chars(digits, digits + sizeof digits, x).ptr).append(" ");
    }
    return text;
}

const char* type_of(int kind)
{
    switch (kind) {
    case LEAGUE_MESH:
    case LEAGUE_HULL:
        return "mesh";
    case LEAGUE_SPHERE:
        return "sphere";
    case LEAGUE_CAPSULE:
        return "capsule";
    case LEAGUE_BOX:
        return "box";
    case LEAGUE_CYLINDER:
        return "cylinder";
    case LEAGUE_ELLIPSOID:
        return "ellipsoid";
    case LEAGUE_HALF_SPACE:
        return "plane";
    default:
        return nullptr;
    }
}

/// The vertices; without faces, MuJoCo takes their hull.
std::string asset_of(const char* name, const league_body& body)
{
    if (std::strcmp(type_of(body.kind), "mesh") != 0) return {};
    std::string text = std::string("<mesh name=\"") + name + "\" vertex=\"";
    for (std::size_t i = 0; i < 3 * body.vertex_count; ++i) text += text_of({body.vertices[i]});
    if (body.kind == LEAGUE_MESH) {
        text += "\" face=\"";
        for (std::size_t i = 0; i < 3 * body.triangle_count; ++i) text += std::to_string(body.triangles[i]) + " ";
    }
    return text + "\"/>\n";
}

std::string geom_of(const char* name, const league_body& body)
{
    const double *r = body.rotation, *t = body.position, *size = body.size;
    std::string text = std::string("<geom name=\"") + name + "\" type=\"" + type_of(body.kind) + "\" pos=\"" +
                       text_of({t[0], t[1], t[2]}) + "\" xyaxes=\"" + text_of({r[0], r[3], r[6], r[1], r[4], r[7]}) +
                       "\" ";
    if (std::strcmp(type_of(body.kind), "mesh") == 0)
        text += std::string("mesh=\"") + name + "\"";
    else if (body.kind == LEAGUE_HALF_SPACE)
        text += "size=\"0 0 1\""; // infinite
    else
        text += "size=\"" + text_of({size[0], size[1], size[2]}) + "\"";
    return text + "/>\n";
}

/// Is at least the distance of the two bodies. One of them is a plane, or both contain their centres.
double margin_of(const league_body& a, const league_body& b)
{
    const auto centre = [](const league_body& body) {
        return league::to_world(body, body.kind == LEAGUE_HULL ? league::mean_vertex(body) : league::Vector{});
    };
    const league::Vector p = centre(a), q = centre(b), apart{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    double least = league::length_of(apart);
    for (const league_body* body : {&a, &b})
        if (body->kind == LEAGUE_HALF_SPACE) least = std::abs(league::to_body_direction(*body, apart)[2]);
    return 1.001 * least + 1e-6;
}

[[noreturn]] void give_up(const char* message)
{
    throw std::runtime_error(message);
}

struct Scene final : league::Query {
    std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
    std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
    int geom_a = -1;
    std::vector<league_contact> contacts;

    explicit Scene(const league_case& asked)
    {
        mju_user_error = give_up; // The default ends the process.
        mju_user_warning = [](const char*) {};
        compile(asked.question == LEAGUE_RAY ? one_geom(asked.a) : two_geoms(asked));
        data.reset(mj_makeData(model.get()));
        if (!data) throw std::bad_alloc();
        mj_kinematics(model.get(), data.get());
        geom_a = mj_name2id(model.get(), mjOBJ_GEOM, "a");
    }

    static std::string one_geom(const league_body& a)
    {
        return "<mujoco><asset>\n" + asset_of("a", a) + "</asset><worldbody>\n" + geom_of("a", a) +
               "</worldbody></mujoco>\n";
    }

    /// There are no contacts without a body that can move, and a plane cannot.
    static std::string two_geoms(const league_case& asked)
    {
        const double margin = asked.question == LEAGUE_DISTANCE ? margin_of(asked.a, asked.b) : 0;
        const std::string a = geom_of("a", asked.a), b = geom_of("b", asked.b);
        const bool b_rests = asked.b.kind == LEAGUE_HALF_SPACE;
        return "<mujoco><option collision=\"predefined\"/><size nconmax=\"100\" njmax=\"100\"/><asset>\n" +
               asset_of("a", asked.a) + asset_of("b", asked.b) + "</asset><worldbody>\n" + (b_rests ? b : a) +
               "<body><freejoint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>\n" + (b_rests ? a : b) +
               "</body></worldbody><contact><pair geom1=\"a\" geom2=\"b\" margin=\"" + text_of({margin}) +
               "\"/></contact></mujoco>\n";
    }

    void compile(const std::string& xml)
    {
        const std::unique_ptr<mjVFS, void (*)(mjVFS*)> files(new mjVFS, [](mjVFS* vfs) {
            mj_deleteVFS(vfs);
            delete vfs;
        });
        mj_defaultVFS(files.get());
        if (mj_makeEmptyFileVFS(files.get(), "case.xml", int(xml.size())) != 0) throw std::bad_alloc();
        std::memcpy(files->filedata[mj_findFileVFS(files.get(), "case.xml")], xml.data(), xml.size());
        char error[1000] = "";
        model.reset(mj_loadXML("case.xml", files.get(), error, sizeof error));
        if (!model) throw std::runtime_error(error);
    }

    /// MuJoCo's normal points from its first geom, which may be b. Its position is in the middle of the two surfaces.
    void find_contacts()
    {
        mj_collision(model.get(), data.get());
        contacts.clear();
        for (int k = 0; k < data->ncon; ++k) {
            const mjContact& found = data->contact[k];
            league_contact& contact = contacts.emplace_back();
            for (int axis = 0; axis < 3; ++axis) {
                contact.position[axis] = found.pos[axis];
                contact.normal[axis] = found.geom1 == geom_a ? found.frame[axis] : -found.frame[axis];
            }
            contact.depth = -found.dist;
        }
    }

    /// The contact of least distance.
    void find_contact(league_answer& answer, double& least)
    {
        find_contacts();
        const auto best = std::max_element(contacts.begin(), contacts.end(),
                                           [](const auto& p, const auto& q) { return p.depth < q.depth; });
        if (best == contacts.end()) return;
        least = -best->depth;
        answer.meet = least <= 0;
        for (int k = 0; k < 3; ++k) {
            answer.normal[k] = best->normal[k];
            answer.point_a[k] = best->position[k] - best->normal[k] * least / 2;
            answer.point_b[k] = best->position[k] + best->normal[k] * least / 2;
        }
    }

    int ray(const league_case& asked, league_answer& answer) const
    {
        int geom = -1;
        answer.time = mj_ray(model.get(), data.get(), asked.from, asked.motion, nullptr, 1, -1, &geom);
        answer.meet = geom >= 0 && answer.time >= 0 && answer.time <= 1;
        return LEAGUE_ANSWERED;
    }

    int answer(const league_case& asked, league_answer& answer) override
    {
        if (asked.question == LEAGUE_RAY) return ray(asked, answer);
        if (asked.question == LEAGUE_CONTACTS) {
            find_contacts();
            answer.meet = !contacts.empty();
            answer.contacts = contacts.data(), answer.contact_count = contacts.size();
            return LEAGUE_ANSWERED;
        }
        double least = HUGE_VAL;
        find_contact(answer, least);
        if (asked.question == LEAGUE_DISTANCE) {
            if (least == HUGE_VAL) return LEAGUE_FAILED;
            answer.distance = std::max(0.0, least);
            answer.has_points = !answer.meet;
        }
        if (asked.question == LEAGUE_DEPTH && answer.meet) answer.depth = -least;
        return LEAGUE_ANSWERED;
    }
};

bool in(int kind, std::initializer_list<int> kinds)
{
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

/// Distances only where MuJoCo has a function for the two kinds. The others grow by the margin, and so their
/// contact is the contact of larger bodies; contacts of two boxes are not their nearest points.
bool has_distance(int kind_a, int kind_b)
{
    const auto half_space = [](int a, int b) {
        return a == LEAGUE_HALF_SPACE && type_of(b) && b != LEAGUE_MESH && b != LEAGUE_HALF_SPACE;
    };
    const auto round = [](int a, int b) {
        return in(a, {LEAGUE_SPHERE, LEAGUE_CAPSULE}) && in(b, {LEAGUE_SPHERE, LEAGUE_CAPSULE, LEAGUE_BOX});
    };
    return half_space(kind_a, kind_b) || half_space(kind_b, kind_a) || round(kind_a, kind_b) || round(kind_b, kind_a);
}

int supports(int question, int kind_a, int kind_b)
{
    const auto known = [](int kind) { return type_of(kind) && kind != LEAGUE_MESH; };
    switch (question) {
    case LEAGUE_MEET:
    case LEAGUE_DEPTH:
    case LEAGUE_CONTACTS:
        return known(kind_a) && known(kind_b) && !(kind_a == LEAGUE_HALF_SPACE && kind_b == LEAGUE_HALF_SPACE);
    case LEAGUE_DISTANCE:
        return has_distance(kind_a, kind_b);
    case LEAGUE_RAY:
        return kind_a == LEAGUE_MESH; // It hits the surface of the others, too, and so not their inside.
    default:
        return 0;
    }
}

std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    return league::needs_inside(asked) ? nullptr : std::make_unique<Scene>(asked);
}

constexpr league_library libraries[] = {league::library_of<prepare>({
    .name = "mujoco",
    .settings =
        "2.2.2; mj_collision() of two geoms as a pair, contacts with dist <= 0 (depth: the deepest); distances by the "
        "pair's margin; mj_ray(); vertices of meshes are single precision",
    .source = "mujoco/mjdata.h (mjContact), mujoco/mujoco.h (mj_ray)",
    .supports = supports,
    .precision = 1e-6, // mpr_tolerance
})};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
