#pragma once

// The shaders of pictures. All coordinates are in the view frame: the eye is the origin and looks along -z.
namespace oncollide::gl {

/// `n` must face the eye. The first light comes over the left shoulder, the second lifts the shadows from the right.
inline constexpr const char* shading = R"(#version 430 core
vec3 shade(vec3 base, vec3 n)
{
    float key = max(dot(n, normalize(vec3(-0.45, 0.75, 0.65))), 0.0);
    float fill = max(dot(n, normalize(vec3(0.80, -0.10, 0.45))), 0.0);
    return base * (0.46 + 0.50 * key + 0.18 * fill);
}
)";

inline constexpr const char* mesh_vertex = R"(#version 430 core
layout(location = 0) uniform mat4 to_view;
layout(location = 1) uniform mat4 projection;
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
out vec3 at;
flat out vec3 side;
void main()
{
    vec4 p = to_view * vec4(position, 1);
    at = p.xyz;
    side = mat3(to_view) * normal;
    gl_Position = projection * p;
}
)";

inline constexpr const char* mesh_fragment = R"(
layout(location = 2) uniform vec4 colour;
in vec3 at;
flat in vec3 side;
out vec4 pixel;
void main()
{
    vec3 n = faceforward(side, at, side);
    float facing = abs(dot(normalize(at), n));
    pixel = vec4(shade(colour.rgb, n), colour.a < 1 ? mix(min(1, 2.2 * colour.a), colour.a, facing) : 1);
}
)";

/// A rectangle around a line, with the line's width, extended by half of it at each end.
inline constexpr const char* line_vertex = R"(#version 430 core
layout(location = 1) uniform mat4 projection;
layout(location = 2) uniform vec2 half_picture; // pixels
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in float width;
layout(location = 3) in vec4 tint;
flat out vec4 colour;
void main()
{
    colour = tint;
    vec4 p = projection * vec4(from, 1), q = projection * vec4(to, 1);
    vec2 way = (q.xy / q.w - p.xy / p.w) * half_picture;
    vec2 along = length(way) > 1e-4 ? normalize(way) : vec2(1, 0), across = vec2(-along.y, along.x);
    bool last = (gl_VertexID & 1) == 1;
    vec4 end = last ? q : p;
    vec2 off = 0.5 * width * ((last ? along : -along) + ((gl_VertexID & 2) == 0 ? across : -across));
    gl_Position = vec4(end.xy / end.w + off / half_picture, 0, 1);
}
)";

inline constexpr const char* line_fragment = R"(#version 430 core
flat in vec4 colour;
out vec4 pixel;
void main()
{
    pixel = vec4(colour.rgb, 1);
}
)";

/// A square that faces the eye and covers the sphere's outline, which in perspective is wider than the sphere.
inline constexpr const char* ball_vertex = R"(#version 430 core
layout(location = 1) uniform mat4 projection;
layout(location = 0) in vec4 ball; // centre, radius
layout(location = 1) in vec4 tint;
out vec3 at;
flat out vec4 sphere;
flat out vec4 colour;
void main()
{
    sphere = ball, colour = tint;
    float far = length(ball.xyz), tangent2 = far * far - ball.w * ball.w;
    if (tangent2 <= 0) { // the eye is inside: nothing to see
        gl_Position = vec4(0, 0, 2, 1);
        return;
    }
    vec3 away = ball.xyz / far;
    vec3 x = normalize(cross(away, abs(away.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0))), y = cross(x, away);
    float half_side = 1.01 * ball.w * far / sqrt(tangent2);
    at = ball.xyz + half_side * ((gl_VertexID & 1) == 0 ? -x : x) + half_side * ((gl_VertexID & 2) == 0 ? -y : y);
    gl_Position = projection * vec4(at, 1);
}
)";

/// Intersects the ray through the pixel with the sphere, starting from the ray's point nearest to the centre, which
/// keeps small spheres round at large distances.
inline constexpr const char* ball_fragment = R"(
layout(location = 1) uniform mat4 projection;
in vec3 at;
flat in vec4 sphere;
flat in vec4 colour;
out vec4 pixel;
void main()
{
    vec3 ray = normalize(at);
    float along = dot(ray, sphere.xyz);
    vec3 off = along * ray - sphere.xyz;
    float depth2 = sphere.w * sphere.w - dot(off, off);
    if (depth2 < 0) discard;
    float depth = sqrt(depth2);
    vec3 n = (off - depth * ray) / sphere.w;
    vec4 clip = projection * vec4((along - depth) * ray, 1);
    gl_FragDepth = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
    // A dark rim tells balls of one colour apart; bubbles are clear in the middle.
    float facing = depth / sphere.w;
    pixel = vec4(shade(colour.rgb, n) * mix(0.55, 1.0, smoothstep(0.0, 0.6, facing)),
                 colour.a < 1 ? colour.a * mix(1.0, 0.3, smoothstep(0.0, 0.9, facing)) : 1);
}
)";

} // namespace oncollide::gl
