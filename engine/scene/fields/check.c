/* Checks of values that come from outside. */
#include "scene/fields/check.h"

#include <stdio.h>

bool daft_check_pointer(daft_error *error, const char *name, const void *pointer)
{
    return pointer || daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is NULL", name);
}

bool daft_check_cookie(daft_error *error, uint32_t cookie, const char *maker)
{
    return cookie == DAFT_COOKIE ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "the definition is not initialised: start from %s()", maker);
}

bool daft_check_range(daft_error *error, const char *name, double value, double low, double high, const char *allowed)
{
    return (value >= low && value <= high) ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is %g; it must be %s", name, value, allowed);
}

bool daft_check_finite(daft_error *error, const char *name, double value)
{
    return daft_check_range(error, name, value, -DBL_MAX, DBL_MAX, "finite");
}

static bool check_components(daft_error *error, const char *name, const double *value, int count, double low,
                             const char *allowed)
{
    for (int i = 0; i < count; i++) {
        if (value[i] >= low && value[i] <= DBL_MAX) continue; /* names are put together only for a message */
        char component[96];
        snprintf(component, sizeof component, "%s.%c", name, "xyzw"[i]);
        return daft_check_range(error, component, value[i], low, DBL_MAX, allowed);
    }
    return true;
}

bool daft_check_finite_position(daft_error *error, const char *name, daft_dvec3 value)
{
    return check_components(error, name, (double[]){value.x, value.y, value.z}, 3, -DBL_MAX, "finite");
}

bool daft_check_finite3(daft_error *error, const char *name, daft_vec3 value)
{
    return daft_check_finite_position(error, name, daft_to_double(value));
}

bool daft_check_color(daft_error *error, const char *name, daft_vec3 value)
{
    return check_components(error, name, (double[]){(double)value.x, (double)value.y, (double)value.z}, 3, 0,
                            "finite and 0 or more");
}

bool daft_check_rotation(daft_error *error, const char *name, daft_quat value)
{
    double components[4] = {(double)value.x, (double)value.y, (double)value.z, (double)value.w};
    if (!check_components(error, name, components, 4, -DBL_MAX, "finite")) return false;
    return value.x != 0 || value.y != 0 || value.z != 0 || value.w != 0 ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is 0, 0, 0, 0; it must be a quaternion that is not zero", name);
}

bool daft_check_direction(daft_error *error, const char *name, daft_vec3 value)
{
    if (!daft_check_finite3(error, name, value)) return false;
    return value.x != 0 || value.y != 0 || value.z != 0 ||
           daft_fail(error, DAFT_ERROR_ARGUMENT, "%s is 0, 0, 0; it must have a length", name);
}

bool daft_check_camera(daft_error *error, const char *name, const daft_camera *camera)
{
    char before[64];
    snprintf(before, sizeof before, "%s.", name);
    return daft_struct_check_named(DAFT_STRUCT_CAMERA, camera, before, error);
}
