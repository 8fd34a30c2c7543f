/* lidar SCENE [FILE.ply]: one sweep of a lidar with 16 beams that stands at the scene's camera. Each ray is a query for
 * the nearest hit; the points become an ASCII PLY file with the distance of each. */
#include <daft.h>
#include <stdio.h>
#include <stdlib.h>

enum { BEAMS = 16, STEPS = 720 };
static const double LOWEST = -0.26, HIGHEST = 0.26; /* radians above the horizon: 15 degrees down, 15 up */
static const float RANGE = 100;                     /* metres */

typedef struct sweep {
    daft_ray_hit hits[BEAMS * STEPS];
    uint32_t count;
} sweep;

static int fail(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "lidar: %s\n", daft_error_text(error, text, sizeof text));
    return 1;
}

/* Directions come from daft_sin and daft_cos, so every machine asks for the same rays and gets the same points. */
static daft_vec3 direction(int beam, int step)
{
    double up = LOWEST + (HIGHEST - LOWEST) * beam / (BEAMS - 1), around = 2 * 3.14159265358979 * step / STEPS;
    return (daft_vec3){(float)(daft_cos(up) * daft_cos(around)), (float)daft_sin(up),
                       (float)(daft_cos(up) * daft_sin(around))};
}

/* A ray that hits nothing returns false, with the code DAFT_OK. */
static bool turn(daft_scene *scene, daft_dvec3 origin, sweep *out, daft_error *error)
{
    out->count = 0;
    for (int step = 0; step < STEPS; step++)
        for (int beam = 0; beam < BEAMS; beam++) {
            daft_ray_hit *hit = &out->hits[out->count];
            if (daft_scene_cast_ray(scene, origin, direction(beam, step), RANGE, (daft_entity){0}, hit, error))
                out->count++;
            else if (error->code != DAFT_OK)
                return false;
        }
    return true;
}

static bool save(const sweep *points, const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file) return false;
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %u\nproperty double x\nproperty double y\nproperty double z\n"
            "property float distance\nend_header\n",
            points->count);
    for (uint32_t i = 0; i < points->count; i++) {
        const daft_ray_hit *hit = &points->hits[i];
        fprintf(file, "%.6f %.6f %.6f %.4f\n", hit->position.x, hit->position.y, hit->position.z,
                (double)hit->distance);
    }
    return fclose(file) == 0;
}

int main(int argc, char **argv)
{
    if (argc < 2) return fprintf(stderr, "usage: lidar SCENE [FILE.ply]\n"), 2;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_scene *scene = engine ? daft_scene_create(engine, &error) : NULL;
    if (!scene || !daft_scene_load(scene, argv[1], &error)) return fail(&error);

    const char *path = argc > 2 ? argv[2] : "sweep.ply";
    sweep *points = malloc(sizeof *points);
    if (!points) return fprintf(stderr, "lidar: out of memory\n"), 1;
    if (!turn(scene, daft_scene_camera(scene, 1).position, points, &error)) return fail(&error);
    if (!save(points, path)) return fprintf(stderr, "lidar: cannot write %s\n", path), 1;
    printf("%u of %d rays hit something within %g m\n", points->count, BEAMS * STEPS, (double)RANGE);

    free(points);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return 0;
}
