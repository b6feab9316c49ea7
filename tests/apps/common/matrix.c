#include "matrix.h"

#include <math.h>

static const double degree = 3.14159265358979323846 / 180.0;

matrix4 matrix_identity(void)
{
    return matrix_scale(1.0);
}

matrix4 matrix_multiply(matrix4 a, matrix4 b)
{
    matrix4 r;
    for (int column = 0; column < 4; column++) {
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += (double)a.m[4 * k + row] * b.m[4 * column + k];
            r.m[4 * column + row] = (float)sum;
        }
    }
    return r;
}

matrix4 matrix_perspective(double fov, double aspect, double near, double far)
{
    double f = 1.0 / tan(0.5 * fov * degree);
    matrix4 r = {{0}};
    r.m[0] = (float)(f / aspect);
    r.m[5] = (float)f;
    r.m[10] = (float)((far + near) / (near - far));
    r.m[11] = -1.0f;
    r.m[14] = (float)(2.0 * far * near / (near - far));
    return r;
}

matrix4 matrix_camera(double yaw, double pitch)
{
    double cy = cos(yaw * degree), sy = sin(yaw * degree);
    double cp = cos(pitch * degree), sp = sin(pitch * degree);
    matrix4 turn_yaw = matrix_identity(), turn_pitch = matrix_identity();
    turn_yaw.m[0] = (float)cy;
    turn_yaw.m[2] = (float)-sy;
    turn_yaw.m[8] = (float)sy;
    turn_yaw.m[10] = (float)cy;
    turn_pitch.m[5] = (float)cp;
    turn_pitch.m[6] = (float)-sp;
    turn_pitch.m[9] = (float)sp;
    turn_pitch.m[10] = (float)cp;
    return matrix_multiply(turn_pitch, turn_yaw);
}

matrix4 matrix_transposed(matrix4 m)
{
    matrix4 transposed;
    for (int i = 0; i < 16; i++)
        transposed.m[i] = m.m[i % 4 * 4 + i / 4];
    return transposed;
}

matrix4 matrix_scale(double factor)
{
    matrix4 r = {{0}};
    r.m[0] = r.m[5] = r.m[10] = (float)factor;
    r.m[15] = 1.0f;
    return r;
}

matrix4 matrix_translate(double x, double y, double z)
{
    matrix4 r = matrix_identity();
    r.m[12] = (float)x;
    r.m[13] = (float)y;
    r.m[14] = (float)z;
    return r;
}

matrix4 matrix_inverse(matrix4 m)
{
    double a[4][8];
    matrix4 result;
    for (int row = 0; row < 4; row++) {
        for (int column = 0; column < 4; column++) {
            a[row][column] = m.m[4 * column + row];
            a[row][4 + column] = row == column;
        }
    }
    for (int pivot = 0; pivot < 4; pivot++) {
        int best = pivot;
        for (int row = pivot; row < 4; row++) {
            if (a[row][pivot] * a[row][pivot] > a[best][pivot] * a[best][pivot])
                best = row;
        }
        for (int column = 0; column < 8; column++) {
            const double other = a[best][column];
            a[best][column] = a[pivot][column];
            a[pivot][column] = other;
        }
        for (int column = 7; column >= 0; column--)
            a[pivot][column] /= a[pivot][pivot];
        for (int row = 0; row < 4; row++) {
            const double factor = a[row][pivot];
            for (int column = 0; row != pivot && column < 8; column++)
                a[row][column] -= factor * a[pivot][column];
        }
    }
    for (int i = 0; i < 16; i++)
        result.m[i] = (float)a[i % 4][4 + i / 4];
    return result;
}

unsigned pixels_to_the_left(const matrix4 *back, unsigned width, unsigned height)
{
    unsigned count = 0;
    for (unsigned i = 0; i < width * height; i++) {
        const double x = 2.0 * (i % width + 0.5) / width - 1.0, y = 2.0 * (i / width + 0.5) / height - 1.0;
        const double across = back->m[0] * x + back->m[4] * y + back->m[8] + back->m[12];
        const double w = back->m[3] * x + back->m[7] * y + back->m[11] + back->m[15];
        count += across * w < 0.0;
    }
    return count;
}
