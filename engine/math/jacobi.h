/* Eigenvectors of symmetric matrices, three by three. */
#ifndef DAFT_JACOBI_H
#define DAFT_JACOBI_H

#include <math.h>

/* One Jacobi rotation that makes a[p][q] zero (Golub and Van Loan, "Matrix Computations", 8.5); v's columns turn with
 * it, so that from the identity they become the eigenvectors. */
static inline void daft_jacobi_rotate(double a[9], double v[9], int p, int q)
{
    const double apq = a[3 * p + q];
    if (apq == 0) return;
    const double theta = (a[4 * q] - a[4 * p]) / (2 * apq);
    const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)), c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < 3; k++) {
        const double x = a[3 * k + p], y = a[3 * k + q];
        a[3 * k + p] = c * x - s * y, a[3 * k + q] = s * x + c * y;
    }
    for (int k = 0; k < 3; k++) {
        double x = a[3 * p + k], y = a[3 * q + k];
        a[3 * p + k] = c * x - s * y, a[3 * q + k] = s * x + c * y;
        x = v[3 * k + p], y = v[3 * k + q];
        v[3 * k + p] = c * x - s * y, v[3 * k + q] = s * x + c * y;
    }
}

#endif
