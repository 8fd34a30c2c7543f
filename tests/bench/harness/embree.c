/* Embree on the same work: medium build quality, packets of 16 rays, the same threads. A mesh that stands once is its
 * own geometry; one that stands often is instanced, two levels. Shadow packets are marked coherent, but for instances,
 * where version 3.13 does not come back from some coherent packets. */
#include "embree.h"

#ifdef DAFT_EMBREE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- scenes ---- */

static void attach(RTCScene scene, RTCGeometry geometry, uint32_t number)
{
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, number);
    rtcReleaseGeometry(geometry);
}

RTCGeometry bench_embree_triangles(RTCDevice device, const daft_trimesh *mesh, const daft_affine *map)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                               3 * sizeof(float), mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        daft_vec3 p = daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]);
        if (map) p = daft_affine_point(map, p);
        positions[3 * i] = p.x, positions[3 * i + 1] = p.y, positions[3 * i + 2] = p.z;
    }
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                            mesh->triangle_count);
    memcpy(indices, mesh->indices, (size_t)mesh->triangle_count * 3 * sizeof(uint32_t));
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
    return geometry;
}

static void add_mesh(const bench_embree *self, RTCScene scene, const daft_trimesh *mesh, const daft_affine *map,
                     uint32_t number)
{
    attach(scene, bench_embree_triangles(self->device, mesh, map), number);
}

static void add_ground(const bench_embree *self)
{
    static const float corners[12] = {-BENCH_GROUND, 0, -BENCH_GROUND, -BENCH_GROUND, 0, BENCH_GROUND,
                                      BENCH_GROUND,  0, BENCH_GROUND,  BENCH_GROUND,  0, -BENCH_GROUND};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4),
           corners, sizeof corners);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), 2),
           triangles, sizeof triangles);
    attach(self->scene, geometry, 1);
}

static RTCScene new_scene(const bench_embree *self)
{
    RTCScene scene = rtcNewScene(self->device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    return scene;
}

static void make_scene(bench_embree *self)
{
    self->scene = new_scene(self);
    add_mesh(self, self->scene, self->mesh, NULL, 0);
    if (self->ground) add_ground(self);
}

static bench_embree *open_device(int threads)
{
    char options[64];
    snprintf(options, sizeof options, "threads=%d", threads);
    bench_embree *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->device = rtcNewDevice(options);
    if (!self->device) return free(self), NULL;
    self->threads = threads;
    self->first_sphere = RTC_INVALID_GEOMETRY_ID - 1;
    return self;
}

static bench_embree *create(const daft_trimesh *mesh, bool ground, int threads)
{
    bench_embree *self = open_device(threads);
    if (!self) return NULL;
    self->mesh = mesh;
    self->ground = ground;
    make_scene(self);
    rtcCommitScene(self->scene);
    return self;
}

/* part: which of self->meshes has the mesh, which is built where it is met first. */
static void add_instance(bench_embree *self, int part, const daft_trimesh *mesh, const daft_affine *map,
                         uint32_t number)
{
    if (!self->meshes[part]) {
        self->meshes[part] = new_scene(self);
        add_mesh(self, self->meshes[part], mesh, NULL, 0);
        rtcCommitScene(self->meshes[part]);
    }
    float rows[12];
    for (int i = 0; i < 3; i++) {
        memcpy(rows + 4 * i, map->m + 3 * i, 3 * sizeof(float));
        rows[4 * i + 3] = map->t[i];
    }
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, self->meshes[part]);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
    attach(self->scene, geometry, number);
}

static void add_spheres(bench_embree *self, const bench_scene *scene)
{
    size_t count = scene->instance_count - self->first_sphere;
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    float *spheres =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), count);
    for (size_t i = 0; i < count; i++) {
        const bench_instance *item = &scene->instances[self->first_sphere + i];
        const float sphere[4] = {item->position.x, item->position.y, item->position.z, item->scale};
        memcpy(spheres + 4 * i, sphere, sizeof sphere);
    }
    attach(self->scene, geometry, self->first_sphere);
}

/* Instances come as: meshes that stand once, then many of one mesh, or spheres to the end. */
static bench_embree *create_scene(const bench_scene *scene, int threads)
{
    bench_embree *self = open_device(threads);
    if (!self) return NULL;
    self->scene = new_scene(self);
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (scene->instances[i].mesh == BENCH_SPHERE) {
            self->first_sphere = i;
            add_spheres(self, scene);
            break;
        }
        bool instanced = !scene->single && i > 0;
        int part = scene->instances[i].mesh;
        daft_affine map = bench_instance_map(&scene->instances[i]);
        self->instanced |= instanced;
        if (instanced)
            add_instance(self, part, &scene->mesh[part], &map, i);
        else
            add_mesh(self, self->scene, &scene->mesh[part], NULL, i);
    }
    rtcCommitScene(self->scene);
    return self;
}

bench_embree *bench_embree_placed(const daft_instance *instances, uint32_t count, bool two_level, int threads)
{
    bench_embree *self = open_device(threads);
    if (!self) return NULL;
    self->scene = new_scene(self);
    self->instanced = two_level;
    for (uint32_t i = 0; i < count; i++) {
        const daft_trimesh *mesh = instances[i].mesh;
        if (two_level)
            add_instance(self, mesh != instances[0].mesh, mesh, &instances[i].to_frame, i);
        else
            add_mesh(self, self->scene, mesh, &instances[i].to_frame, i);
    }
    rtcCommitScene(self->scene);
    return self;
}

void bench_embree_close(bench_embree *self)
{
    if (!self) return;
    rtcReleaseScene(self->scene);
    for (int i = 0; i < 2; i++)
        if (self->meshes[i]) rtcReleaseScene(self->meshes[i]);
    rtcReleaseDevice(self->device);
    free(self);
}

static double build_ms(bench_embree *self)
{
    rtcReleaseScene(self->scene);
    make_scene(self);
    double start = daft_clock_ms();
    rtcCommitScene(self->scene);
    return daft_clock_ms() - start;
}

/* ---- camera rays: a task is a row of tiles of 4 by 4 rays ---- */

typedef struct camera_job {
    const bench_embree *self;
    const bench_view *view;
    uint64_t hits[64]; /* one for each worker */
} camera_job;

static void trace_row(void *context, uint32_t row, uint32_t worker)
{
    camera_job *job = context;
    struct RTCRayHit16 packet __attribute__((aligned(64)));
    uint64_t hits = 0;
    for (int x = 0; x < job->view->width; x += 4) {
        bench_embree_intersect(job->self, true, bench_embree_rays(job->view, x, (int)row * 4, &packet));
        for (int i = 0; i < 16; i++) hits += packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    }
    job->hits[worker] += hits;
}

/* Width and height: multiples of four. */
static double camera_ms(bench_embree *self, const bench_view *view, uint64_t *hits)
{
    camera_job job = {.self = self, .view = view};
    double start = bench_clock_ms(self->threads);
    daft_parallel_for(self->threads, (uint32_t)view->height / 4, trace_row, &job);
    double ms = bench_clock_ms(self->threads) - start;
    *hits = 0;
    for (size_t i = 0; i < DAFT_COUNT_OF(job.hits); i++) *hits += job.hits[i];
    return ms;
}

static const bench_embree_api API = {
    "Embree " RTC_VERSION_STRING, create, create_scene, bench_embree_close, build_ms, camera_ms, bench_embree_frame_ms};

const bench_embree_api *bench_find_embree(void) { return &API; }
#else
const bench_embree_api *bench_find_embree(void) { return NULL; }
#endif
