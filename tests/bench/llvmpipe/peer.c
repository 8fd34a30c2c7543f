/* A frame: the shadow map, then surfaces by groups, nearest first, then the sky where nothing is. */
#include "llvmpipe/peer.h"

#include <GL/osmesa.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where a program's uniforms are. */
typedef struct surface_program {
    GLuint name;
    GLint map_scale, ambient, emission, diffuse, specular, mirror, transmittance, shininess, transmission, index, blur;
} surface_program;

struct peer {
    peer_def def;
    OSMesaContext context;
    uint8_t window[4 * 16 * 16]; /* OSMesa wants one; pictures go to framebuffers of their own */
    GLuint target, single;       /* the same where a pixel has one sample */
    peer_assets assets;
    peer_groups groups;
    peer_shadow shadow;
    peer_light_counts lights; /* that the programs are for */
    surface_program programs[PEER_PROGRAMS];
    GLuint sky_program, no_array;
};

/* ---- context and framebuffers ---- */

static bool make_target(const peer_def *def, int samples, GLuint *out)
{
    GLuint color, depth;
    glGenFramebuffers(1, out);
    glBindFramebuffer(GL_FRAMEBUFFER, *out);
    glGenRenderbuffers(1, &color), glGenRenderbuffers(1, &depth);
    glBindRenderbuffer(GL_RENDERBUFFER, color);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_SRGB8_ALPHA8, def->width, def->height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, def->width, def->height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

/* One thread: llvmpipe has none beside the calling one. More: so many rasterize. */
static bool make_context(peer *self)
{
    char count[16];
    snprintf(count, sizeof count, "%d", self->def.threads > 1 ? self->def.threads : 0);
    setenv("LP_NUM_THREADS", count, 1);
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    const int wanted[] = {OSMESA_FORMAT,
                          OSMESA_RGBA,
                          OSMESA_DEPTH_BITS,
                          0,
                          OSMESA_PROFILE,
                          OSMESA_CORE_PROFILE,
                          OSMESA_CONTEXT_MAJOR_VERSION,
                          3,
                          OSMESA_CONTEXT_MINOR_VERSION,
                          3,
                          0};
    self->context = OSMesaCreateContextAttribs(wanted, NULL);
    if (!self->context || !OSMesaMakeCurrent(self->context, self->window, GL_UNSIGNED_BYTE, 16, 16)) return false;
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    if (renderer && strncmp(renderer, "llvmpipe", 8) == 0) return true;
    fprintf(stderr, "daft_llvmpipe: OSMesa draws with %s\n", renderer ? renderer : "nothing");
    return false;
}

peer *peer_create(const peer_def *def)
{
    peer *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->def = *def;
    self->assets.allocator = daft_malloc_allocator();
    bool good = make_context(self) && make_target(def, 0, &self->single);
    if (good && def->antialiased) good = make_target(def, 4, &self->target);
    if (good && !def->antialiased) self->target = self->single;
    good = good && peer_shadow_create(&self->shadow) && (self->sky_program = peer_sky_program());
    if (good) {
        glGenVertexArrays(1, &self->no_array);
        return self;
    }
    fprintf(stderr, "daft_llvmpipe: OpenGL 3.3 does not start\n");
    peer_destroy(self);
    return NULL;
}

void peer_destroy(peer *self)
{
    if (!self) return;
    peer_groups_free(&self->groups, &self->assets.allocator);
    peer_shadow_free(&self->shadow, &self->assets.allocator);
    peer_assets_free(&self->assets);
    if (self->context) OSMesaDestroyContext(self->context);
    free(self);
}

/* ---- the camera ---- */

typedef struct camera {
    float to_clip[16]; /* column-major */
    peer_planes inside;
} camera;

static float farthest(const daft_snapshot *s)
{
    float most = 10;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const daft_instance *a = &s->instances[i];
        const daft_vec3 corner = {fmaxf(-a->low.x, a->high.x), fmaxf(-a->low.y, a->high.y),
                                  fmaxf(-a->low.z, a->high.z)};
        most = fmaxf(most, daft_length(corner));
    }
    return most;
}

/* A plane's row of a clip matrix: last row plus or minus another one. */
static void add_plane(camera *c, int row, float sign)
{
    float *out = c->inside.at[c->inside.count++];
    for (int k = 0; k < 4; k++) out[k] = c->to_clip[4 * k + 3] + sign * c->to_clip[4 * k + row];
}

static camera camera_of(const daft_snapshot *s)
{
    const float near = 0.05f, far = 1.01f * farthest(s), depth = (far + near) / (far - near);
    const daft_vec3 rows[4] = {daft_scale(s->right, 2 * s->focal / (float)s->width),
                               daft_scale(s->up, 2 * s->focal / (float)s->height), daft_scale(s->forward, depth),
                               s->forward};
    camera c = {.inside.count = 0};
    for (int i = 0; i < 4; i++) c.to_clip[i] = rows[i].x, c.to_clip[4 + i] = rows[i].y, c.to_clip[8 + i] = rows[i].z;
    c.to_clip[14] = -2 * far * near / (far - near);
    for (int row = 0; row < 3; row++) {
        add_plane(&c, row, 1);
        if (row < 2) add_plane(&c, row, -1);
    }
    return c;
}

/* ---- programs and lights ---- */

static peer_light_counts count_lights(const daft_snapshot *s)
{
    peer_light_counts c = {0};
    for (uint32_t i = 0; i < s->light_count && i < PEER_LIGHTS; i++) {
        const daft_light_source *light = &s->lights[i];
        if (light->sun)
            c.shadow |= c.suns++ == 0 && light->casts_shadow;
        else if (light->spot)
            c.spots++;
        else
            c.points++;
    }
    return c;
}

/* By their kinds: suns, points, spots. */
static void set_lights(GLuint program, const daft_snapshot *s, const peer_light_counts *counts)
{
    daft_vec3 at[PEER_LIGHTS], color[PEER_LIGHTS], axis[PEER_LIGHTS] = {{0, 0, 0}};
    float cone[PEER_LIGHTS][2] = {{0, 0}}, range2[PEER_LIGHTS];
    int places[3] = {0, counts->suns, counts->suns + counts->points};
    for (uint32_t i = 0; i < s->light_count && i < PEER_LIGHTS; i++) {
        const daft_light_source *light = &s->lights[i];
        const int kind = light->sun    ? 0
                         : light->spot ? 2
                                       : 1,
                  k = places[kind]++, spot = k - counts->suns - counts->points;
        at[k] = light->sun ? light->to_light : light->position, color[k] = light->color;
        range2[k] = light->range > 0 ? 1 / (light->range * light->range) : 0;
        if (kind == 2) axis[spot] = light->to_light, cone[spot][0] = light->cone_cosine;
        if (kind == 2) cone[spot][1] = light->cone_scale;
    }
    const int count = counts->suns + counts->points + counts->spots;
    if (count == 0) return;
    glUniform3fv(glGetUniformLocation(program, "light_at"), count, &at[0].x);
    glUniform3fv(glGetUniformLocation(program, "light_color"), count, &color[0].x);
    glUniform1fv(glGetUniformLocation(program, "range2"), count, range2);
    if (counts->spots) glUniform3fv(glGetUniformLocation(program, "spot_axis"), counts->spots, &axis[0].x);
    if (counts->spots) glUniform2fv(glGetUniformLocation(program, "spot_cone"), counts->spots, &cone[0][0]);
}

static surface_program make_program(uint32_t traits, const peer_light_counts *lights)
{
    const GLuint p = peer_surface_program(traits, lights);
    surface_program out = {.name = p};
    if (!p) return out;
#define FIND(member) out.member = glGetUniformLocation(p, #member)
    FIND(map_scale), FIND(ambient), FIND(emission), FIND(diffuse), FIND(specular), FIND(mirror), FIND(transmittance);
    FIND(shininess), FIND(transmission), FIND(index), FIND(blur);
#undef FIND
    glUseProgram(p);
    glUniform1i(glGetUniformLocation(p, "picture"), 0);
    glUniform1i(glGetUniformLocation(p, "shadow_map"), 1);
    glUniform1i(glGetUniformLocation(p, "sky"), 2);
    return out;
}

/* Makes the programs that the frame needs anew where its lights are others; sets what all groups share. */
static bool prepare_programs(peer *self, const daft_snapshot *s, const camera *c)
{
    const peer_light_counts lights = count_lights(s);
    const bool same = lights.suns == self->lights.suns && lights.points == self->lights.points &&
                      lights.spots == self->lights.spots && lights.shadow == self->lights.shadow;
    for (uint32_t i = 0; i < PEER_PROGRAMS; i++) {
        surface_program *p = &self->programs[i];
        if (!p->name || !same) {
            glDeleteProgram(p->name);
            *p = make_program(i, &lights);
        }
        if (!p->name) return false;
        glUseProgram(p->name);
        glUniformMatrix4fv(glGetUniformLocation(p->name, "view"), 1, GL_FALSE, c->to_clip);
        glUniformMatrix4fv(glGetUniformLocation(p->name, "shadow_from"), 1, GL_FALSE, self->shadow.from_frame);
        set_lights(p->name, s, &lights);
    }
    self->lights = lights;
    return true;
}

/* ---- surfaces ---- */

static uint32_t traits_of(const daft_surface *m)
{
    const bool mirrors = m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0;
    const uint32_t traits = daft_surface_traits(m);
    return (traits & DAFT_TRAIT_TEXTURE ? PEER_TEXTURE : 0u) | (traits & DAFT_TRAIT_SPECULAR ? PEER_SPECULAR : 0u) |
           (mirrors ? PEER_MIRROR : 0u) | (m->transmission > 0 ? PEER_CLEAR : 0u);
}

static void set_color(GLint at, daft_vec3 c) { glUniform3f(at, c.x, c.y, c.z); }

static void set_material(peer *self, const daft_snapshot *s, const daft_surface *m)
{
    const surface_program *p = &self->programs[traits_of(m)];
    const daft_vec3 a = s->ambient.by_normal ? s->ambient.harmonics[0] : s->ambient.color; /* of a sky, its mean */
    glUseProgram(p->name);
    set_color(p->ambient, (daft_vec3){m->ambient.x * a.x, m->ambient.y * a.y, m->ambient.z * a.z});
    set_color(p->emission, m->emission), set_color(p->diffuse, m->diffuse), set_color(p->specular, m->specular);
    set_color(p->mirror, m->mirror), set_color(p->transmittance, m->transmittance);
    glUniform1f(p->shininess, m->shininess), glUniform1f(p->transmission, m->transmission);
    glUniform1f(p->index, m->index > 0 ? m->index : 1);
    glUniform1f(p->blur, sqrtf(sqrtf(m->alpha)) * 0.8f * (float)(self->assets.sky_levels - 1));
    glUniform2f(p->map_scale, m->map_scale.x, m->map_scale.y);
    if (m->texture == DAFT_NO_TEXTURE) return;
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, peer_texture_of(&self->assets, &s->textures[m->texture]));
}

static void draw_surfaces(peer *self, const daft_snapshot *s)
{
    glEnable(GL_DEPTH_TEST), glDepthFunc(GL_LESS), glDepthMask(GL_TRUE);
    glActiveTexture(GL_TEXTURE1), glBindTexture(GL_TEXTURE_2D, self->shadow.map);
    for (size_t i = 0; i < self->groups.count; i++) {
        const peer_group *group = &self->groups.items[i];
        set_material(self, s, &s->materials[group->material]);
        peer_group_draw(&self->groups, &self->assets, group);
    }
}

static void draw_sky(peer *self, const daft_snapshot *s)
{
    const float x = (float)s->width / (2 * s->focal), y = (float)s->height / (2 * s->focal);
    glDepthFunc(GL_LEQUAL), glDepthMask(GL_FALSE);
    glUseProgram(self->sky_program);
    set_color(glGetUniformLocation(self->sky_program, "right"), daft_scale(s->right, x));
    set_color(glGetUniformLocation(self->sky_program, "up"), daft_scale(s->up, y));
    set_color(glGetUniformLocation(self->sky_program, "forward"), s->forward);
    glUniform1i(glGetUniformLocation(self->sky_program, "sky"), 2);
    glBindVertexArray(self->no_array);
    glDisable(GL_CULL_FACE);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static const daft_light_source *shadowing_sun(const daft_snapshot *s)
{
    for (uint32_t i = 0; i < s->light_count && i < PEER_LIGHTS; i++)
        if (s->lights[i].sun) return s->lights[i].casts_shadow ? &s->lights[i] : NULL;
    return NULL;
}

bool peer_draw(peer *self, const daft_snapshot *s)
{
    const camera c = camera_of(s);
    const daft_light_source *sun = shadowing_sun(s);
    glActiveTexture(GL_TEXTURE2);
    const GLuint sky = peer_sky_of(&self->assets, &s->sky);
    if (!sky) return false;
    glBindTexture(GL_TEXTURE_CUBE_MAP, sky);
    if (sun && !peer_shadow_draw(&self->shadow, &self->assets, s, sun)) return false;
    if (!peer_groups_fill(&self->groups, &self->assets, s, &c.inside, false)) return false;
    if (!prepare_programs(self, s, &c)) return false;
    glBindFramebuffer(GL_FRAMEBUFFER, self->target);
    glViewport(0, 0, self->def.width, self->def.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glDepthMask(GL_TRUE);
    glClear(GL_DEPTH_BUFFER_BIT);
    draw_surfaces(self, s);
    draw_sky(self, s);
    if (self->def.antialiased) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, self->target), glBindFramebuffer(GL_DRAW_FRAMEBUFFER, self->single);
        glBlitFramebuffer(0, 0, self->def.width, self->def.height, 0, 0, self->def.width, self->def.height,
                          GL_COLOR_BUFFER_BIT, GL_NEAREST);
    }
    glDisable(GL_FRAMEBUFFER_SRGB);
    glFinish();
    return glGetError() == GL_NO_ERROR;
}

void peer_read(peer *self, uint8_t *rgba)
{
    const size_t row = 4 * (size_t)self->def.width;
    glBindFramebuffer(GL_FRAMEBUFFER, self->single);
    for (int y = 0; y < self->def.height; y++)
        glReadPixels(0, self->def.height - 1 - y, self->def.width, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                     rgba + (size_t)y * row);
}
