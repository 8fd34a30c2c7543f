/* Where instances are seen from a pencil's apex: the map to view space, and the pixels that an instance's bounds may
 * cover. */
#include "raster/raster.h"
#include "math/exact.h"

daft_affine daft_pencil_map(const daft_pencil *p, const daft_affine *frame)
{
    const daft_vec3 axes[3] = {p->right, p->up, p->forward}, o = p->origin;
    const double x = (double)frame->t[0] - (double)o.x, y = (double)frame->t[1] - (double)o.y,
                 z = (double)frame->t[2] - (double)o.z;
    daft_affine map;
    for (int i = 0; i < 3; i++) {
        daft_dvec3 axis = daft_to_double(axes[i]);
        for (int j = 0; j < 3; j++)
            map.m[3 * i + j] = (float)(axis.x * (double)frame->m[j] + axis.y * (double)frame->m[3 + j] +
                                       axis.z * (double)frame->m[6 + j]);
        map.t[i] = (float)(axis.x * x + axis.y * y + axis.z * z);
    }
    return map;
}

static void view_box(const daft_view_instance *view, daft_vec3 *low, daft_vec3 *high)
{
    daft_instance moved;
    moved.mesh = view->mesh, moved.bvh = view->bvh, moved.radius = view->instance->radius,
    moved.to_frame = view->to_view;
    daft_instance_bound(&moved); /* reads no more of it */
    *low = moved.low;
    *high = moved.high;
}

/* The pixels whose rays, or those within `reach` pixels of them, may meet a box: exclusive of those whose rays lie
 * beyond a side of it. False: none. */
static bool pixel_range(float low, float high, float near_z, float far_z, double focal, double centre, double reach,
                        int size, int *first, int *last)
{
    double a = 0, b = size - 1;
    if (near_z > 0) {
        double l = (double)low, h = (double)high, nz = (double)near_z, fz = (double)far_z;
        a = focal * (l < 0 ? l / nz : l / fz) + (centre - reach);
        b = focal * (h < 0 ? h / fz : h / nz) + (centre + reach);
        a = ceil((a < 0 ? 0 : a) - 1e-3);
        b = floor((b > size - 1 ? size - 1 : b) + 1e-3);
    }
    if (!(a <= b) || a > size - 1 || b < 0) return false;
    *first = a < 0 ? 0 : (int)a;
    *last = b > size - 1 ? size - 1 : (int)b;
    return true;
}

/* A box with corners in front of and behind the camera's plane: is all of it beyond one side of the frustum? */
static bool outside_sides(const daft_pencil *p, daft_vec3 low, daft_vec3 high)
{
    double half_x = (double)p->width * 0.5 + 1, half_y = (double)p->height * 0.5 + 1;
    double f = (double)p->focal, z = (double)high.z;
    return (double)low.x * f > z * half_x || -(double)high.x * f > z * half_x || (double)low.y * f > z * half_y ||
           -(double)high.y * f > z * half_y;
}

static bool sphere_range(const daft_pencil *p, daft_view_instance *view, double cx, double cy)
{
    const float *c = view->to_view.t;
    double z = (double)c[2], r = (double)view->instance->radius * (1 + 0x1p-20) + fabs(z) * 0x1p-20,
           f = (double)p->focal, reach = (double)p->reach;
    if (!(z > r * 1.001)) return true; /* around the camera or through its plane: the whole picture */
    double x0, x1, y0, y1;
    daft_sphere_slopes((double)c[0], z, r, &x0, &x1);
    daft_sphere_slopes(-(double)c[1], z, r, &y0, &y1);
    return pixel_range((float)x0, (float)x1, 1, 1, f, cx, reach, p->width, &view->x0, &view->x1) &&
           pixel_range((float)y0, (float)y1, 1, 1, f, cy, reach, p->height, &view->y0, &view->y1);
}

bool daft_view_instance_make(const daft_pencil *p, const daft_instance *instance, uint32_t index,
                             daft_view_instance *view)
{
    if (instance->mesh && instance->mesh->triangle_count == 0) return false;
    *view = (daft_view_instance){.instance = instance, .mesh = instance->mesh, .bvh = instance->bvh, .index = index};
    view->to_view = daft_pencil_map(p, &instance->to_frame);
    daft_vec3 low, high;
    view_box(view, &low, &high);
    if (!daft_finite3(low) || !daft_finite3(high) || high.z <= 0 || outside_sides(p, low, high)) return false;
    view->near_z = low.z;
    double f = (double)p->focal, reach = (double)p->reach;
    double cx = daft_pencil_middle_x(p), cy = daft_pencil_middle_y(p);
    if (!pixel_range(low.x, high.x, low.z, high.z, f, cx, reach, p->width, &view->x0, &view->x1) ||
        !pixel_range(-high.y, -low.y, low.z, high.z, f, cy, reach, p->height, &view->y0, &view->y1))
        return false;
    if (!instance->mesh) return sphere_range(p, view, cx, cy);
    view->dense = daft_view_dense(view);
    return true;
}
