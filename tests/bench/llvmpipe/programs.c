/* The shaders. A surface's is compiled for what its material has and for the lights of the frame: no branch is left. */
#include "llvmpipe/peer.h"

#include <stdio.h>
#include <string.h>

static const char SURFACE_VERTEX[] =
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec2 uv;\n"
    "layout(location = 3) in vec4 row0;\n"
    "layout(location = 4) in vec4 row1;\n"
    "layout(location = 5) in vec4 row2;\n"
    "uniform mat4 view, shadow_from;\n"
    "uniform vec2 map_scale;\n"
    "out vec3 place, turned, under;\n"
    "out vec2 at;\n"
    "void main() {\n"
    "    vec4 p = vec4(position, 1);\n"
    "    place = vec3(dot(row0, p), dot(row1, p), dot(row2, p));\n"
    "    turned = vec3(dot(cross(row1.xyz, row2.xyz), normal), dot(cross(row2.xyz, row0.xyz), normal),\n"
    "                  dot(cross(row0.xyz, row1.xyz), normal));\n"
    "    at = uv * map_scale;\n"
    "    under = (shadow_from * vec4(place, 1)).xyz;\n"
    "    gl_Position = view * vec4(place, 1);\n"
    "}\n";

/* As engine/shade/tone_kernel.c has it. */
static const char TONE[] =
    "uniform float exposure;\n"
    "vec3 toned(vec3 light) {\n"
    "#ifdef EXPOSED\n"
    "    light = max(light * exposure, 0);\n"
    "#endif\n"
    "#ifdef ACES\n"
    "    light *= 0.72317;\n"
    "    light = light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14);\n"
    "#endif\n"
    "#ifdef AGX\n"
    "    vec3 x = log2(max(light * mat3(0.842479062, 0.0784336, 0.0792237451, 0.0423282423, 0.878468636, "
    "0.0791661275,\n"
    "                                   0.042375655, 0.0784336, 0.879142974), 1e-10));\n"
    "    x = clamp((x + 12.47393) / 16.5, 0, 1);\n"
    "    x = (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232;\n"
    "    x = x * mat3(1.19687901, -0.0980208811, -0.0990297441, -0.0528968518, 1.15190313, -0.0989611768,\n"
    "                 -0.0529716355, -0.0980434501, 1.15107367);\n"
    "    light = pow(clamp(x, 0, 1), vec3(2.2));\n"
    "#endif\n"
    "    return light;\n"
    "}\n";

static const char SURFACE_FRAGMENT[] =
    "in vec3 place, turned, under;\n"
    "in vec2 at;\n"
    "out vec4 color;\n"
    "uniform vec3 light_color[SUNS + POINTS + SPOTS + 1], light_at[SUNS + POINTS + SPOTS + 1];\n"
    "uniform vec3 spot_axis[SPOTS + 1];\n"
    "uniform vec2 spot_cone[SPOTS + 1];\n"
    "uniform float range2[SUNS + POINTS + SPOTS + 1];\n"
    "uniform vec3 ambient, emission, diffuse, specular, mirror, transmittance;\n"
    "uniform float shininess, transmission, index, blur;\n"
    "uniform sampler2D picture, opacity_map;\n"
    "uniform sampler2DShadow shadow_map;\n"
    "uniform sampler2DArrayShadow lamp_maps;\n" /* six faces of each cube, then cones */
    "uniform vec2 cube_depth[CUBES + 1], cone_depth[CONES + 1];\n"
    "uniform vec3 cone_across[CONES + 1], cone_up[CONES + 1];\n"
    "uniform samplerCube sky;\n"
    "uniform float opacity, cutoff;\n"
    "uniform vec4 channel;\n"
    "uniform vec3 harmonics[9];\n"
    "vec3 around(vec3 n) {\n"
    "#ifdef AROUND\n"
    "    vec3 sum = harmonics[0] + n.x * harmonics[1] + n.y * harmonics[2] + n.z * harmonics[3];\n"
    "    sum += n.x * n.y * harmonics[4] + n.y * n.z * harmonics[5] + n.x * n.z * harmonics[6];\n"
    "    return max(sum + (3 * n.z * n.z - 1) * harmonics[7] + (n.x * n.x - n.y * n.y) * harmonics[8], 0);\n"
    "#else\n"
    "    return harmonics[0];\n"
    "#endif\n"
    "}\n"
    "float sunlight() {\n"
    "    float lit = 0;\n"
    "    for (int y = -1; y <= 1; y++)\n"
    "        for (int x = -1; x <= 1; x++) lit += texture(shadow_map, under + vec3(x, y, 0) / 2048);\n"
    "    return lit / 9;\n"
    "}\n"
    "float cube_light(int k, vec3 to_light) {\n"
    "    vec3 p = -to_light, a = abs(p);\n"
    "    bool x = a.x >= max(a.y, a.z), y = !x && a.y >= a.z;\n"
    "    float major = x ? p.x : y ? p.y : p.z, along = 1 / abs(major), side = sign(major);\n"
    "    vec2 st = vec2(x ? -side * p.z : y ? p.x : side * p.x, y ? side * p.z : -p.y) * (0.5 * along) + 0.5;\n"
    "    float face = (x ? 0.5 : y ? 2.5 : 4.5) - 0.5 * side + float(6 * k);\n"
    "    return texture(lamp_maps, vec4(st, face, cube_depth[k].x + cube_depth[k].y * along));\n"
    "}\n"
    "float cone_light(int k, vec3 to_light) {\n"
    "    float along = 1 / max(dot(to_light, spot_axis[k]), 1e-4);\n"
    "    vec2 at = 0.5 - vec2(dot(to_light, cone_across[k]), dot(to_light, cone_up[k])) * along;\n"
    "    return texture(lamp_maps, vec4(at, 6 * CUBES + k, cone_depth[k].x + cone_depth[k].y * along));\n"
    "}\n"
    "vec3 reflected(vec3 l, float cosine, vec3 n, vec3 eye, vec3 albedo) {\n"
    "    vec3 sum = diffuse * albedo * cosine;\n"
    "#ifdef SPECULAR\n"
    "    sum += specular * pow(max(2 * cosine * dot(n, eye) - dot(l, eye), 1e-6), shininess);\n"
    "#endif\n"
    "    return cosine > 0 ? sum : vec3(0);\n"
    "}\n"
    /* Called with constants, so that no loop is left with arrays that are read by a variable. */
    "vec3 lamp(int i, vec3 n, vec3 eye, vec3 albedo) {\n"
    "    vec3 to_light = light_at[i] - place;\n"
    "    float length2 = dot(to_light, to_light), left = max(1 - length2 * range2[i], 0);\n"
    "    vec3 l = to_light * inversesqrt(length2);\n"
    "    vec3 part = light_color[i] * reflected(l, dot(n, l), n, eye, albedo) * left * left;\n"
    "    int spot = i - SUNS - POINTS;\n"
    "    if (spot >= 0) {\n"
    "        float t = clamp((dot(l, spot_axis[spot]) - spot_cone[spot].x) * spot_cone[spot].y, 0, 1);\n"
    "        part *= t * t * (3 - 2 * t);\n"
    "    }\n"
    "#if CUBES > 0\n"
    "    if (i < SUNS + CUBES) part *= cube_light(i - SUNS, to_light);\n"
    "#endif\n"
    "#if CONES > 0\n"
    "    if (spot >= 0 && spot < CONES) part *= cone_light(spot, to_light);\n"
    "#endif\n"
    "    return part;\n"
    "}\n"
    "void main() {\n"
    "    float there = opacity;\n"
    "#ifdef OPACITY\n"
    "    there *= dot(texture(opacity_map, at), channel);\n"
    "#endif\n"
    "#ifdef MASK\n"
    "    if (there < cutoff) discard;\n"
    "#endif\n"
    "    vec3 eye = -normalize(place), n = normalize(gl_FrontFacing ? turned : -turned);\n"
    "#ifdef TEXTURE\n"
    "    vec3 albedo = texture(picture, at).rgb;\n"
    "#else\n"
    "    vec3 albedo = vec3(1);\n"
    "#endif\n"
    "    vec3 sum = emission + ambient * albedo * around(n);\n"
    "    for (int i = 0; i < SUNS; i++) {\n"
    "        vec3 part = light_color[i] * reflected(light_at[i], dot(n, light_at[i]), n, eye, albedo);\n"
    "#ifdef SHADOW\n"
    "        if (i == 0) part *= sunlight();\n"
    "#endif\n"
    "        sum += part;\n"
    "    }\n"
    "    LAMPS\n"
    "#ifdef MIRROR\n"
    "    sum += mirror * textureLod(sky, reflect(-eye, n), blur).rgb;\n"
    "#endif\n"
    "#ifdef CLEAR\n"
    "    float f0 = (index - 1) / (index + 1), away = 1 - max(dot(n, eye), 0);\n"
    "    float fresnel = f0 * f0 + (1 - f0 * f0) * away * away * away * away * away;\n"
    "    vec3 through = transmittance * textureLod(sky, refract(-eye, n, 1 / index), blur).rgb;\n"
    "    sum += mix(through, transmission * textureLod(sky, reflect(-eye, n), blur).rgb, fresnel);\n"
    "#endif\n"
    "#ifdef BLEND\n"
    "    color = vec4(toned(sum) * there, there);\n"
    "#else\n"
    "    color = vec4(toned(sum), 1);\n"
    "#endif\n"
    "}\n";

static const char DEPTH_VERTEX[] = "layout(location = 0) in vec3 position;\n"
                                   "layout(location = 3) in vec4 row0;\n"
                                   "layout(location = 4) in vec4 row1;\n"
                                   "layout(location = 5) in vec4 row2;\n"
                                   "layout(location = 2) in vec2 uv;\n"
                                   "uniform mat4 view;\n"
                                   "uniform vec2 map_scale;\n"
                                   "out vec2 at;\n"
                                   "void main() {\n"
                                   "    vec4 p = vec4(position, 1);\n"
                                   "    gl_Position = view * vec4(dot(row0, p), dot(row1, p), dot(row2, p), 1);\n"
                                   "    at = uv * map_scale;\n"
                                   "}\n";

static const char DEPTH_FRAGMENT[] = "in vec2 at;\n"
                                     "uniform sampler2D opacity_map;\n"
                                     "uniform float opacity, cutoff;\n"
                                     "uniform vec4 channel;\n"
                                     "void main() {\n"
                                     "#ifdef MASK\n"
                                     "    if (opacity * dot(texture(opacity_map, at), channel) < cutoff) discard;\n"
                                     "#endif\n"
                                     "}\n";

/* One triangle over the whole picture, behind everything. */
static const char SKY_VERTEX[] = "uniform vec3 right, up, forward;\n"
                                 "out vec3 towards;\n"
                                 "void main() {\n"
                                 "    vec2 p = vec2(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1);\n"
                                 "    towards = right * p.x + up * p.y + forward;\n"
                                 "    gl_Position = vec4(p, 1, 1);\n"
                                 "}\n";

static const char SKY_FRAGMENT[] = "in vec3 towards;\n"
                                   "out vec4 color;\n"
                                   "uniform samplerCube sky;\n"
                                   "void main() { color = vec4(toned(textureLod(sky, towards, 0).rgb), 1); }\n";

static GLuint compile(GLenum kind, const char *head, const char *body)
{
    const char *const parts[] = {"#version 330 core\n", head, kind == GL_FRAGMENT_SHADER ? TONE : "", body};
    GLuint shader = glCreateShader(kind);
    GLint good = 0;
    glShaderSource(shader, 4, parts, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good) return shader;
    char log[2000] = "";
    glGetShaderInfoLog(shader, sizeof log, NULL, log);
    fprintf(stderr, "daft_llvmpipe: a shader does not compile:\n%s", log);
    glDeleteShader(shader);
    return 0;
}

static GLuint link_program(const char *head, const char *vertex, const char *fragment)
{
    GLuint program = glCreateProgram(), v = compile(GL_VERTEX_SHADER, head, vertex),
           f = compile(GL_FRAGMENT_SHADER, head, fragment);
    GLint good = 0;
    if (v && f) {
        glAttachShader(program, v), glAttachShader(program, f);
        glLinkProgram(program);
        glGetProgramiv(program, GL_LINK_STATUS, &good);
    }
    glDeleteShader(v), glDeleteShader(f);
    if (good) return program;
    fprintf(stderr, "daft_llvmpipe: a program does not link\n");
    glDeleteProgram(program);
    return 0;
}

uint32_t peer_traits_of(const daft_surface *m)
{
    const bool mirrors = m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0;
    const bool blends = daft_surface_blends(m);
    const uint32_t traits = daft_surface_traits(m);
    uint32_t out = traits & DAFT_TRAIT_TEXTURE ? PEER_TEXTURE : 0;
    if (traits & DAFT_TRAIT_SPECULAR) out |= PEER_SPECULAR;
    if (mirrors) out |= PEER_MIRROR;
    if (m->transmission > 0) out |= PEER_CLEAR;
    if (blends && m->maps[DAFT_MAP_ALPHA] != DAFT_NO_TEXTURE) out |= PEER_OPACITY;
    if (blends) out |= m->cutoff > 0 ? PEER_MASK : PEER_BLEND;
    return out;
}

static void frame_head(const peer_frame_traits *frame, char *out, size_t size)
{
    snprintf(out, size,
             "#define SUNS %d\n#define POINTS %d\n#define SPOTS %d\n"
             "#define CUBES %d\n#define CONES %d\n%s%s%s%s%s",
             frame->suns, frame->points, frame->spots, frame->cubes, frame->cones,
             frame->shadow ? "#define SHADOW\n" : "", frame->around ? "#define AROUND\n" : "",
             frame->exposed ? "#define EXPOSED\n" : "", frame->curve == DAFT_TONE_ACES ? "#define ACES\n" : "",
             frame->curve == DAFT_TONE_AGX ? "#define AGX\n" : "");
}

static void add_lamps(const peer_frame_traits *frame, char *head, size_t size)
{
    size_t used = strlen(head);
    used += (size_t)snprintf(head + used, size - used, "#define LAMPS");
    for (int i = frame->suns; i < frame->suns + frame->points + frame->spots; i++)
        used += (size_t)snprintf(head + used, size - used, " sum += lamp(%d, n, eye, albedo);", i);
    snprintf(head + used, size - used, "\n");
}

GLuint peer_surface_program(uint32_t traits, const peer_frame_traits *frame)
{
    static const char *const NAMES[] = {"TEXTURE", "SPECULAR", "MIRROR", "CLEAR", "OPACITY", "MASK", "BLEND"};
    char head[4096]; /* PEER_LIGHTS lines of 36 */
    frame_head(frame, head, sizeof head);
    add_lamps(frame, head, sizeof head);
    for (uint32_t i = 0; i < sizeof NAMES / sizeof NAMES[0]; i++)
        if (traits >> i & 1) strcat(strcat(strcat(head, "#define "), NAMES[i]), "\n");
    return link_program(head, SURFACE_VERTEX, SURFACE_FRAGMENT);
}

GLuint peer_depth_program(bool mask)
{
    return link_program(mask ? "#define MASK\n" : "", DEPTH_VERTEX, DEPTH_FRAGMENT);
}

GLuint peer_sky_program(const peer_frame_traits *frame)
{
    char head[256];
    frame_head(frame, head, sizeof head);
    return link_program(head, SKY_VERTEX, SKY_FRAGMENT);
}
