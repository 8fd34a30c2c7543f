/* What enters through daft.h is checked here. Every message names the field, the value that came and what is allowed.
 * Public headers: check.h number.h Inner headers: fields.h */
#ifndef DAFT_CHECK_H
#define DAFT_CHECK_H

#include "scene/fields/fields.h"

bool daft_check_pointer(daft_error *error, const char *name, const void *pointer);
bool daft_check_cookie(daft_error *error, uint32_t cookie, const char *maker);
/* low <= value <= high, and not NaN. `allowed` finishes "it must be …". */
bool daft_check_range(daft_error *error, const char *name, double value, double low, double high, const char *allowed);
bool daft_check_finite(daft_error *error, const char *name, double value);
bool daft_check_finite3(daft_error *error, const char *name, daft_vec3 value);
bool daft_check_finite_position(daft_error *error, const char *name, daft_dvec3 value);
/* Linear light: each component finite and not negative. */
bool daft_check_color(daft_error *error, const char *name, daft_vec3 value);
/* Finite and not all zero. */
bool daft_check_rotation(daft_error *error, const char *name, daft_quat value);
bool daft_check_direction(daft_error *error, const char *name, daft_vec3 value);
bool daft_check_camera(daft_error *error, const char *name, const daft_camera *camera);

#endif
