/* The league's interface: all that a library of collision detection needs to take part. C99, no other header.
 *
 * An adapter is a shared object with one function, league_open(). The league loads it in a process of its own, with limits on time and
 * memory: a crash or an endless loop is a result. Try yours: oncollide-lab league --adapter ./mine.so --library mine --cases 1000
 */
#ifndef ONCOLLIDE_LEAGUE_H
#define ONCOLLIDE_LEAGUE_H
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LEAGUE_VERSION 2

enum league_kind {
    LEAGUE_MESH,      /* triangles */
    LEAGUE_HULL,      /* the convex hull of the vertices */
    LEAGUE_SPHERE,    /* size[0]: radius */
    LEAGUE_CAPSULE,   /* size[0]: radius, size[1]: half the length of the segment, along z */
    LEAGUE_BOX,       /* size: half extents */
    LEAGUE_CYLINDER,  /* size[0]: radius, size[1]: half the height, along z */
    LEAGUE_CONE,      /* size[0]: radius of the base at -size[1], size[1]: half the height; the tip is at +size[1] on z */
    LEAGUE_ELLIPSOID, /* size: half axes */
    LEAGUE_HALF_SPACE,/* z <= 0 */
    LEAGUE_TERRAIN,   /* a surface of triangles that is not closed; they are given as those of a mesh */
    LEAGUE_CELLS,     /* cubes of side size[0]; the vertices are their centres */
    LEAGUE_KIND_COUNT
};

/* A body. Lengths in metres. A point p of its own frame is at rotation * p + position. Pointers stay valid until release(). */
typedef struct league_body {
    int32_t kind;
    int32_t solid; /* a mesh: 1: it is closed, and its inside belongs to it; 0: it is its surface alone */
    double size[3];
    size_t vertex_count;
    const double *vertices; /* x, y, z of each */
    size_t triangle_count;
    const uint32_t *triangles; /* three vertices of each; counter-clockwise seen from outside, if closed */
    double rotation[9];        /* row by row */
    double position[3];
} league_body;

enum league_question {
    LEAGUE_MEET,     /* Do the two bodies have a point in common? -> meet */
    LEAGUE_DISTANCE, /* How far apart are they? -> distance (0 if they meet), points */
    LEAGUE_DEPTH,    /* Which least translation of b parts them? -> meet, depth, normal (unit; b moves by depth * normal) */
    LEAGUE_CONTACTS, /* Which contacts keep the two apart in a simulation? -> meet, contacts; none if they do not meet */
    LEAGUE_CAST,     /* b moves by `motion`, a rests: when do they first meet? -> meet, time from 0 to 1 */
    LEAGUE_TURN,     /* The same, and b turns by `turn` about its own origin meanwhile, both at a constant rate */
    LEAGUE_RAY,      /* Where does the segment from `from` to `from + motion` first meet body a? -> meet, time from 0 to 1 */
    LEAGUE_PAIRS,    /* Which of `bodies` have AABBs with a common point? Bodies are boxes without rotation. -> pairs */
    LEAGUE_SELF,     /* Have two triangles of mesh a a common point beyond the vertices and edges that they share? -> meet */
    LEAGUE_QUESTION_COUNT
};

/* What is asked. */
typedef struct league_case {
    int32_t question;
    league_body a, b;
    double from[3], motion[3];
    double turn[3]; /* the axis in the world, as long as the angle in radians, which may be more than a half turn */
    size_t body_count;
    const league_body *bodies;
} league_case;

/* A point where the two bodies press on each other. */
typedef struct league_contact {
    double position[3]; /* in the world, between the two surfaces */
    double normal[3];   /* unit; b moves along it to part from a */
    double depth;       /* by this much; negative: they are apart here */
} league_contact;

typedef struct league_answer {
    int32_t meet; /* 1 or 0 */
    int32_t has_points;
    double distance, depth, time;
    double error; /* how far off the library says this number may be, metres (at most .05 of the bodies' sizes counts) or a
                   * share of the motion; 0: its precision */
    double normal[3];
    double point_a[3], point_b[3]; /* the nearest points, if has_points; in the world */
    size_t pair_count;
    const uint32_t *pairs; /* two bodies each; valid until the next call */
    size_t contact_count;
    const league_contact *contacts; /* valid until the next call */
    double seconds; /* the time that the library took, if the adapter measures it, as for one in another language; 0: the
                     * league measures it */
} league_answer;

enum league_state {
    LEAGUE_ANSWERED,
    LEAGUE_UNSUPPORTED, /* the library has no such question, or not for these kinds */
    LEAGUE_FAILED       /* the library says that it failed */
};

typedef struct league_library {
    int32_t version;      /* LEAGUE_VERSION */
    int32_t bits;         /* 64, or 32: all numbers of a case are rounded to float first, and judged as rounded */
    const char *name;     /* one word, as in --library */
    const char *settings; /* its version and how it is used, for the page: "0.7.0; BVHModel<OBBRSS>, collide()" */
    const char *source;   /* where its documentation says so: "fcl/narrowphase/collision.h" */
    double precision;     /* its numbers are promised within this share of the sum of both diameters; 0: 1e-6. Whether
                           * triangles and meshes meet, and rays hit, is judged exactly */
    int32_t conservative; /* 1: it may say that bodies meet that are apart, and never the reverse */

    /* Does it have this question? 1 or 0. Kinds of a ray and of a mesh against itself: twice a's; of pairs: boxes. */
    int (*supports)(int question, int kind_a, int kind_b);
    /* Builds all that the library keeps between queries; not timed. NULL: unsupported, such as sizes beyond those that its
     * documentation allows (cases have 1e-10 to 1e10 m). If it failed: answer LEAGUE_FAILED later. */
    void *(*prepare)(const league_case *asked);
    /* Answers, timed, once or several times. */
    int (*answer)(void *prepared, const league_case *asked, league_answer *answer);
    void (*release)(void *prepared);
} league_library;

/* The libraries of this adapter, by number from 0; NULL after the last. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const league_library *league_open(int number);

#ifdef __cplusplus
}
#endif
#endif
