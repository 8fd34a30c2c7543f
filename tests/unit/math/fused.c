#include "fused.h"

#include <math.h>

float multiply_add_float(float a, float b, float c) { return a * b + c; }
double multiply_add_double(double a, double b, double c) { return a * b + c; }
float fused_float(float a, float b, float c) { return fmaf(a, b, c); }
