/* A sum that a compiler would love to fuse, compiled with the engine's flags for a processor that can. */
#ifndef DAFT_TESTS_FUSED_H
#define DAFT_TESTS_FUSED_H

float multiply_add_float(float a, float b, float c);
double multiply_add_double(double a, double b, double c);
float fused_float(float a, float b, float c); /* fused on purpose */

#endif
