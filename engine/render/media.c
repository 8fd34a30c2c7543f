/* Stacks of media, and what lies between two of them. */
#include "render/media.h"

static int depth_of(const daft_media *media)
{
    int count = 0;
    while (count < DAFT_MEDIA && media->material[count] != DAFT_NO_MEDIUM) count++;
    return count;
}

uint32_t daft_media_winner(const daft_media *media, const daft_surface *materials)
{
    uint32_t best = media->material[0];
    for (int i = 1; i < DAFT_MEDIA && media->material[i] != DAFT_NO_MEDIUM; i++)
        if (materials[media->material[i]].priority >= materials[best].priority) best = media->material[i];
    return best;
}

static void take_out(daft_media *media, int at)
{
    for (int i = at; i + 1 < DAFT_MEDIA; i++) media->material[i] = media->material[i + 1];
    media->material[DAFT_MEDIA - 1] = DAFT_NO_MEDIUM;
}

static void enter(daft_media *media, const daft_surface *materials, uint32_t material)
{
    int count = depth_of(media), least = 0;
    if (count == DAFT_MEDIA) {
        for (int i = 1; i < DAFT_MEDIA; i++)
            if (materials[media->material[i]].priority < materials[media->material[least]].priority) least = i;
        if (materials[material].priority < materials[media->material[least]].priority) return;
        take_out(media, least), count--;
    }
    media->material[count] = material;
}

void daft_media_pass(daft_media *media, const daft_surface *materials, uint32_t material, bool leaves)
{
    if (!leaves) {
        enter(media, materials, material);
        return;
    }
    for (int i = depth_of(media) - 1; i >= 0; i--) {
        if (media->material[i] != material) continue;
        take_out(media, i);
        return;
    }
}

void daft_media_learn(daft_media *media, uint32_t material)
{
    const int count = depth_of(media);
    for (int i = 0; i < count; i++)
        if (media->material[i] == material) return;
    if (count == DAFT_MEDIA) return;
    for (int i = count; i > 0; i--) media->material[i] = media->material[i - 1];
    media->material[0] = material;
}

static bool ranks(const daft_surface *materials, uint32_t medium)
{
    return medium != DAFT_NO_MEDIUM && materials[medium].priority > 0;
}

float daft_media_eta(const daft_media *from, const daft_media *beyond, const daft_surface *materials, uint32_t material,
                     bool leaves)
{
    const uint32_t near = daft_media_winner(from, materials), far = daft_media_winner(beyond, materials);
    const float own = materials[material].index;
    if (near == far && ranks(materials, near)) return 0;
    const float here = ranks(materials, near) ? materials[near].index : leaves ? own : 1;
    const float there = ranks(materials, far) ? materials[far].index : leaves ? 1 : own;
    return here / there;
}

daft_vec3 daft_media_loss(const daft_media *media, const daft_surface *materials, float length)
{
    const uint32_t medium = daft_media_winner(media, materials);
    if (medium == DAFT_NO_MEDIUM) return daft_v3(0, 0, 0);
    return daft_scale(materials[medium].absorption, length);
}

static bool facet_from_inside(const daft_instance *instance, uint32_t triangle, daft_vec3 outward)
{
    const daft_trimesh *mesh = instance->mesh;
    const uint32_t *corner = &mesh->indices[3 * (size_t)triangle];
    if (mesh->normals) {
        const uint32_t *at = mesh->normal_indices ? &mesh->normal_indices[3 * (size_t)triangle] : corner;
        /* mostly all three say the same, whatever their lengths */
        const daft_vec3 towards = daft_affine_vector(&instance->to_object, outward);
        const float a = daft_dot(mesh->normals[at[0]], towards), b = daft_dot(mesh->normals[at[1]], towards),
                    c = daft_dot(mesh->normals[at[2]], towards);
        if (a > 0 && b > 0 && c > 0) return false;
        if (a < 0 && b < 0 && c < 0) return true;
        daft_vec3 sum = {0, 0, 0};
        for (int k = 0; k < 3; k++)
            sum = daft_add(sum, daft_normalize(daft_affine_transposed(&instance->to_object, mesh->normals[at[k]])));
        return daft_dot(sum, outward) < 0;
    }
    daft_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = daft_v3(mesh->x[corner[k]], mesh->y[corner[k]], mesh->z[corner[k]]);
    daft_vec3 local = daft_cross(daft_sub(p[1], p[0]), daft_sub(p[2], p[0]));
    return daft_dot(daft_affine_transposed(&instance->to_object, local), outward) < 0;
}

bool daft_seen_from_inside(const daft_instance *instance, uint32_t triangle, daft_vec3 point, daft_vec3 outward)
{
    if (instance->mesh) return facet_from_inside(instance, triangle, outward);
    const float *centre = instance->to_frame.t;
    return daft_dot(daft_sub(point, daft_v3(centre[0], centre[1], centre[2])), outward) < 0;
}
