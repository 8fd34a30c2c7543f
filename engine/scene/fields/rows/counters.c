/* What frames and ticks took. */
#include "scene/fields/fields.h"

#define ROW(m, ...) DAFT_ROW(daft_counters, m, __VA_ARGS__)
#define SIM(m, ...) DAFT_ROW(daft_sim_counters, m, __VA_ARGS__)

static const daft_field ROWS[] = {
    ROW(width, .unit = "pixels", .doc = "Of the picture"),
    ROW(height, .unit = "pixels", .doc = "Of the picture"),
    ROW(threads, .doc = "Worker threads"),
    ROW(isa, .doc = "The instruction set of the kernels"),
    ROW(frame_ms, .unit = "ms", .doc = "What the whole frame took"),
    ROW(camera_rays, .doc = "Rays from the camera"),
    ROW(shadow_rays, .doc = "Rays towards lights"),
    ROW(reflection_rays, .doc = "Mirrored rays"),
    ROW(refraction_rays, .doc = "Refracted rays, and those mirrored at such surfaces"),
    ROW(query_rays, .doc = "Rays that queries cast, since the scene was made"),
    ROW(instances_seen, .doc = "Instances that some tile looked at"),
    ROW(triangles_tested, .doc = "Triangles whose bounds on the screen were tested, once for each tile"),
    ROW(triangles_binned, .doc = "Triangles that were set up in tiles"),
    ROW(spheres_binned, .doc = "Spheres put into lists of tiles"),
    ROW(tiles_drawn,
        .doc = "Tiles of 32 x 32 pixels that were drawn; the others have not changed since the picture before"),
    ROW(exact_edges, .doc = "Edge tests that floats could not decide"),
    ROW(exact_depths, .doc = "Comparisons of depth that floats could not decide"),
    ROW(shadow_points_kept, .doc = "Lit points that something may hide: the only ones that cast a ray"),
    ROW(alpha_rays, .doc = "Rays towards lights and around that asked surfaces with alpha what they let through"),
    ROW(alpha_reads, .doc = "Hits of these rays that read the texture: on triangles that it covers in part"),
    ROW(mesh_builds, .doc = "BVHs built since the scene was made"),
    ROW(mesh_refits, .doc = "BVHs fitted to moved vertices since the scene was made"),
    ROW(poses, .doc = "Clips sampled and skins moved, for pictures and for rays, since the scene was made"),
    ROW(poses_unseen, .doc = "Poses that pictures went without, since nothing that the clips reach was in sight"),
    ROW(instance_updates, .doc = "Frames since the scene was made that rebuilt the list of instances"),
    ROW(ev, .unit = "stops", .doc = "The picture's exposure: light was times 2^ev"),
    DAFT_OTHER_ROW(daft_counters, effects,
                   .doc = "What each effect did: whether it ran, why, its tiles, rays, bytes, ms"),
};

const daft_field_list daft_counters_fields = DAFT_FIELD_LIST(daft_counters, ROWS);

static const daft_field SIM_ROWS[] = {
    SIM(bodies, .lua = "bodies", .doc = "Bodies there are"),
    SIM(awake, .lua = "awake", .doc = "Dynamic bodies that are awake"),
    SIM(joints, .lua = "joints", .doc = "Joints there are"),
    SIM(islands, .lua = "islands", .doc = "Groups of awake bodies that touch or are joined"),
    SIM(pairs, .lua = "pairs", .doc = "Pairs of parts whose bounds overlap"),
    SIM(contacts, .lua = "contacts", .doc = "Pairs of parts that touch"),
    SIM(rows, .lua = "rows", .doc = "Constraints solved in each substep"),
    SIM(colours, .lua = "colours", .doc = "Groups of constraints that share no body, solved one after the other"),
    SIM(substeps, .lua = "substeps", .doc = "Substeps of the step, the most of any island; 0 where nothing was solved"),
    SIM(sweeps, .lua = "sweeps", .doc = "Searches for the time of an impact"),
};

const daft_field_list daft_sim_counters_fields = DAFT_FIELD_LIST(daft_sim_counters, SIM_ROWS);
