/* A frame: the shadow maps, then surfaces by groups, nearest first, then the sky where nothing is, then what blends. */
#include "llvmpipe/peer.h"

#include <GL/osmesa.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where a program's uniforms are. */
typedef struct surface_program {
    GLuint name;
    uint64_t frame; /* that it has been told of */
    GLint map_scale, ambient, emission, diffuse, specular, mirror, transmittance, shininess, transmission, index, blur;
} surface_program;

struct peer {
    peer_def def;
    OSMesaContext context;
    uint8_t window[4 * 16 * 16]; /* OSMesa wants one; pictures go to framebuffers of their own */
    GLuint target, single;       /* the same where a pixel has one sample */
    peer_assets assets;
    peer_groups groups;
    peer_casters casters;
    peer_shadow shadow;
    peer_lamps lamps;
    peer_lights lights;       /* of the frame */
    peer_frame_traits traits; /* that the programs are for */
    uint64_t frame;
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
    self->assets.allocator = daft_malloc_allocator(), self->assets.trilinear = def->all_shadows;
    bool good = make_context(self) && make_target(def, 0, &self->single);
    if (good && def->antialiased) good = make_target(def, 4, &self->target);
    if (good && !def->antialiased) self->target = self->single;
    good = good && peer_casters_create(&self->casters) && peer_shadow_create(&self->shadow) &&
           (!def->all_shadows || peer_lamps_create(&self->lamps));
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
    peer_casters_free(&self->casters, &self->assets.allocator);
    peer_assets_free(&self->assets);
    if (self->context) OSMesaDestroyContext(self->context);
    free(self);
}

/* ---- the camera ---- */

typedef struct camera {
    float to_clip[16]; /* column-major */
    peer_sight sight;
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
    float *out = c->sight.inside.at[c->sight.inside.count++];
    for (int k = 0; k < 4; k++) out[k] = c->to_clip[4 * k + 3] + sign * c->to_clip[4 * k + row];
}

static camera camera_of(const daft_snapshot *s)
{
    const float near = 0.05f, far = 1.01f * farthest(s), depth = (far + near) / (far - near);
    const daft_vec3 rows[4] = {daft_scale(s->right, 2 * s->focal / (float)s->width),
                               daft_scale(s->up, 2 * s->focal / (float)s->height), daft_scale(s->forward, depth),
                               s->forward};
    camera c = {.sight.inside.count = 0};
    for (int i = 0; i < 4; i++) c.to_clip[i] = rows[i].x, c.to_clip[4 + i] = rows[i].y, c.to_clip[8 + i] = rows[i].z;
    c.to_clip[14] = -2 * far * near / (far - near);
    for (int row = 0; row < 3; row++) {
        add_plane(&c, row, 1);
        if (row < 2) add_plane(&c, row, -1);
    }
    for (int i = 0; i < 4; i++) {
        const float x = far * (float)s->width / (2 * s->focal), y = far * (float)s->height / (2 * s->focal);
        const daft_vec3 p = daft_add(daft_scale(s->forward, far), daft_scale(s->right, i & 1 ? x : -x));
        c.sight.corners[i + 1] = daft_add(p, daft_scale(s->up, i & 2 ? y : -y));
    }
    return c;
}

/* ---- programs and lights ---- */

static peer_frame_traits traits_of_frame(const daft_snapshot *s, const peer_lights *lights)
{
    return (peer_frame_traits){.suns = lights->suns,
                               .points = lights->points,
                               .spots = lights->spots,
                               .cubes = lights->cubes,
                               .cones = lights->cones,
                               .shadow = lights->suns && lights->items[0]->casts_shadow,
                               .around = s->ambient.by_normal,
                               .exposed = daft_tone_changes(&s->tone),
                               .curve = s->tone.curve};
}

static void set_maps(GLuint program, const peer_lights *lights, const peer_lamps *lamps)
{
    if (lights->cubes)
        glUniform2fv(glGetUniformLocation(program, "cube_depth"), lights->cubes, &lamps->cube_depth[0][0]);
    if (!lights->cones) return;
    glUniform2fv(glGetUniformLocation(program, "cone_depth"), lights->cones, &lamps->cone_depth[0][0]);
    glUniform3fv(glGetUniformLocation(program, "cone_across"), lights->cones, &lamps->cone_across[0].x);
    glUniform3fv(glGetUniformLocation(program, "cone_up"), lights->cones, &lamps->cone_up[0].x);
}

static void set_lights(GLuint program, const peer_lights *lights)
{
    daft_vec3 at[PEER_LIGHTS], color[PEER_LIGHTS], axis[PEER_LIGHTS] = {{0, 0, 0}};
    float cone[PEER_LIGHTS][2] = {{0, 0}}, range2[PEER_LIGHTS];
    const int count = lights->suns + lights->points + lights->spots;
    if (count == 0) return;
    for (int i = 0; i < count; i++) {
        const daft_light_source *light = lights->items[i];
        const int spot = i - lights->suns - lights->points;
        at[i] = light->sun ? light->to_light : light->position, color[i] = light->color;
        range2[i] = light->range > 0 ? 1 / (light->range * light->range) : 0;
        if (spot < 0) continue;
        axis[spot] = light->to_light, cone[spot][0] = light->cone_cosine, cone[spot][1] = light->cone_scale;
    }
    glUniform3fv(glGetUniformLocation(program, "light_at"), count, &at[0].x);
    glUniform3fv(glGetUniformLocation(program, "light_color"), count, &color[0].x);
    glUniform1fv(glGetUniformLocation(program, "range2"), count, range2);
    if (lights->spots) glUniform3fv(glGetUniformLocation(program, "spot_axis"), lights->spots, &axis[0].x);
    if (lights->spots) glUniform2fv(glGetUniformLocation(program, "spot_cone"), lights->spots, &cone[0][0]);
}

static surface_program make_program(uint32_t traits, const peer_frame_traits *frame)
{
    const GLuint p = peer_surface_program(traits, frame);
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
    glUniform1i(glGetUniformLocation(p, "lamp_maps"), 4);
    return out;
}

static void set_exposure(GLuint program, const daft_snapshot *s)
{
    glUniform1f(glGetUniformLocation(program, "exposure"), exp2f(s->tone.ev));
}

/* Programs for other frames are of no use. */
static bool begin_programs(peer *self, const daft_snapshot *s)
{
    const peer_frame_traits traits = traits_of_frame(s, &self->lights), *old = &self->traits;
    const bool same = traits.suns == old->suns && traits.points == old->points && traits.spots == old->spots &&
                      traits.cubes == old->cubes && traits.cones == old->cones && traits.shadow == old->shadow &&
                      traits.around == old->around && traits.exposed == old->exposed && traits.curve == old->curve;
    self->frame++, self->traits = traits;
    if (same && self->sky_program) return true;
    for (uint32_t i = 0; i < PEER_PROGRAMS; i++) {
        glDeleteProgram(self->programs[i].name);
        self->programs[i] = (surface_program){0};
    }
    glDeleteProgram(self->sky_program);
    return (self->sky_program = peer_sky_program(&traits));
}

/* Made when it is first called for; told once a frame of what all groups share. NULL: it fails. */
static const surface_program *use_program(peer *self, uint32_t traits, const daft_snapshot *s, const camera *c)
{
    surface_program *p = &self->programs[traits];
    if (!p->name) *p = make_program(traits, &self->traits);
    if (!p->name) return NULL;
    glUseProgram(p->name);
    if (p->frame == self->frame) return p;
    p->frame = self->frame;
    glUniformMatrix4fv(glGetUniformLocation(p->name, "view"), 1, GL_FALSE, c->to_clip);
    glUniformMatrix4fv(glGetUniformLocation(p->name, "shadow_from"), 1, GL_FALSE, self->shadow.from_frame);
    const daft_vec3 *around = s->ambient.by_normal ? s->ambient.harmonics : &s->ambient.color;
    glUniform3fv(glGetUniformLocation(p->name, "harmonics"), s->ambient.by_normal ? DAFT_HARMONICS : 1, &around->x);
    set_exposure(p->name, s);
    set_lights(p->name, &self->lights);
    set_maps(p->name, &self->lights, &self->lamps);
    return p;
}

/* ---- surfaces ---- */

static void set_color(GLint at, daft_vec3 c) { glUniform3f(at, c.x, c.y, c.z); }

static bool set_material(peer *self, const daft_snapshot *s, const camera *c, const daft_surface *m)
{
    const uint32_t traits = peer_traits_of(m);
    const surface_program *p = use_program(self, traits, s, c);
    if (!p) return false;
    set_color(p->ambient, m->ambient);
    set_color(p->emission, m->emission), set_color(p->diffuse, m->diffuse), set_color(p->specular, m->specular);
    set_color(p->mirror, m->mirror), set_color(p->transmittance, m->transmittance);
    glUniform1f(p->shininess, m->shininess), glUniform1f(p->transmission, m->transmission);
    glUniform1f(p->index, m->index > 0 ? m->index : 1);
    glUniform1f(p->blur, sqrtf(sqrtf(m->alpha)) * 0.8f * (float)(self->assets.sky_levels - 1));
    glUniform2f(p->map_scale, m->map_scale.x, m->map_scale.y);
    if (traits & (PEER_MASK | PEER_BLEND)) peer_set_opacity(&self->assets, s, m, p->name);
    if (m->texture == DAFT_NO_TEXTURE) return true;
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, peer_texture_of(&self->assets, &s->textures[m->texture], false));
    return true;
}

static bool draw_surfaces(peer *self, const daft_snapshot *s, const camera *c, bool blends)
{
    glEnable(GL_DEPTH_TEST), glDepthFunc(GL_LESS), glDepthMask(!blends);
    (blends ? glEnable : glDisable)(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glActiveTexture(GL_TEXTURE1), glBindTexture(GL_TEXTURE_2D, self->shadow.map);
    glActiveTexture(GL_TEXTURE4), glBindTexture(GL_TEXTURE_2D_ARRAY, self->lamps.maps);
    for (size_t i = 0; i < self->groups.count; i++) {
        const peer_group *group = &self->groups.items[i];
        if (group->blends != blends) continue;
        if (!set_material(self, s, c, &s->materials[group->material])) return false;
        peer_group_draw(&self->groups, &self->assets, group, false);
    }
    glDisable(GL_BLEND);
    return true;
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
    set_exposure(self->sky_program, s);
    glBindVertexArray(self->no_array);
    glDisable(GL_CULL_FACE);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static bool draw_maps(peer *self, const daft_snapshot *s, const camera *c)
{
    const peer_lights *lights = &self->lights;
    if (lights->suns && lights->items[0]->casts_shadow &&
        !peer_shadow_draw(&self->shadow, &self->casters, &self->assets, s, lights->items[0]))
        return false;
    return lights->cubes + lights->cones == 0 ||
           peer_lamps_draw(&self->lamps, &self->casters, &self->assets, s, lights, &c->sight);
}

bool peer_draw(peer *self, const daft_snapshot *s)
{
    const camera c = camera_of(s);
    const peer_pick seen = {.inside = c.sight.inside};
    peer_lights_find(&self->lights, s, self->def.all_shadows);
    glActiveTexture(GL_TEXTURE2);
    const GLuint sky = peer_sky_of(&self->assets, &s->sky);
    if (!sky) return false;
    glBindTexture(GL_TEXTURE_CUBE_MAP, sky);
    if (!draw_maps(self, s, &c)) return false;
    if (!peer_groups_fill(&self->groups, &self->assets, s, &seen)) return false;
    if (!begin_programs(self, s)) return false;
    glBindFramebuffer(GL_FRAMEBUFFER, self->target);
    glViewport(0, 0, self->def.width, self->def.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glDepthMask(GL_TRUE);
    glClear(GL_DEPTH_BUFFER_BIT);
    if (!draw_surfaces(self, s, &c, false)) return false;
    draw_sky(self, s);
    if (!draw_surfaces(self, s, &c, true)) return false;
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
