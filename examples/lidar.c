/* lidar SCENE [FILE.ply]: one turn of a lidar with 16 beams that stands at the scene's camera, with the error of a real
 * one: 2 cm, and one return in a hundred lost. The points become an ASCII PLY file with the range of each. */
#include <daft.h>
#include <stdio.h>
#include <stdlib.h>

static int fail(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "lidar: %s\n", daft_error_text(error, text, sizeof text));
    return 1;
}

static uint32_t count_points(const daft_scan_return *returns, uint32_t rays)
{
    uint32_t points = 0;
    for (uint32_t i = 0; i < rays; i++) points += returns[i].range > 0;
    return points;
}

static bool save(const daft_scan_def *scan, const daft_scan_return *returns, uint32_t points, const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file) return false;
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %u\nproperty double x\nproperty double y\nproperty double z\n"
            "property float range\nend_header\n",
            points);
    for (uint32_t i = 0; i < daft_scan_size(scan); i++) {
        daft_dvec3 from;
        daft_vec3 way;
        const double range = (double)returns[i].range;
        if (!(range > 0) || !daft_scan_ray(scan, i, &from, &way, NULL, NULL)) continue;
        fprintf(file, "%.6f %.6f %.6f %.4f\n", from.x + range * (double)way.x, from.y + range * (double)way.y,
                from.z + range * (double)way.z, range);
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

    daft_scan_def scan = daft_default_scan_def();
    scan.position = daft_scene_camera(scene, 1).position;
    scan.rows = 16, scan.columns = 720;
    scan.bottom = -0.26f, scan.top = 0.26f; /* radians: 15 degrees down, 15 up */
    scan.max_range = 100;
    scan.range_noise = 0.02f, scan.drop_out = 0.01f;

    const char *path = argc > 2 ? argv[2] : "sweep.ply";
    const uint32_t rays = daft_scan_size(&scan);
    daft_scan_return *returns = malloc(rays * sizeof *returns);
    if (!returns) return fprintf(stderr, "lidar: out of memory\n"), 1;
    if (!daft_scan(scene, &scan, returns, NULL, &error)) return fail(&error);
    const uint32_t points = count_points(returns, rays);
    if (!save(&scan, returns, points, path)) return fprintf(stderr, "lidar: cannot write %s\n", path), 1;
    printf("%u of %u rays came back from within %g m\n", points, rays, (double)scan.max_range);

    free(returns);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return 0;
}
