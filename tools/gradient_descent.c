/* The gradient-descent step of attest_mav/filters/gradient_descent.py in C, timed by tools/bench_filters.

   Reads 500 samples of nine numbers. Prints the attitude after one pass over them, so that it can be compared, and
   the best time of 30 blocks of 20,000 steps, in nanoseconds a step. */

#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <time.h>

#define SAMPLES 500
#define BLOCKS 30
#define STEPS 20000

static double gyro[SAMPLES][3], accel[SAMPLES][3], mag[SAMPLES][3];

static double norm3(const double *v) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static void step(double *q, double *f_g, double *f_b, const double *w, const double *f, const double *m, double dt,
                 double beta)
{
    double u[3] = {0.5 * dt * w[0], 0.5 * dt * w[1], 0.5 * dt * w[2]};
    double sq = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], c, s;
    if (sq < 1e-3) {
        c = 1.0 - sq * (0.5 - sq * (1.0 / 24.0 - sq * (1.0 / 720.0)));
        s = 1.0 - sq * (1.0 / 6.0 - sq * (1.0 / 120.0 - sq * (1.0 / 5040.0)));
    } else {
        double angle = sqrt(sq);
        c = cos(angle);
        s = sin(angle) / angle;
    }
    double x = s * u[0], y = s * u[1], z = s * u[2];
    double q1 = q[0] * c - q[1] * x - q[2] * y - q[3] * z;
    double q2 = q[0] * x + q[1] * c + q[2] * z - q[3] * y;
    double q3 = q[0] * y - q[1] * z + q[2] * c + q[3] * x;
    double q4 = q[0] * z + q[1] * y - q[2] * x + q[3] * c;

    double f_norm = norm3(f), m_norm = norm3(m);
    double down[3] = {2.0 * (q2 * q4 - q1 * q3), 2.0 * (q3 * q4 + q1 * q2), q1 * q1 - q2 * q2 - q3 * q3 + q4 * q4};
    double north[3] = {1.0 - 2.0 * (q3 * q3 + q4 * q4), 2.0 * (q2 * q3 - q1 * q4), 2.0 * (q1 * q3 + q2 * q4)};
    double k = -1.0 / f_norm, l = 1.0 / m_norm;
    double d[3] = {l * m[0], l * m[1], l * m[2]};
    double b_z = down[0] * d[0] + down[1] * d[1] + down[2] * d[2];
    double b_x = sqrt(fmax(0.0, 1.0 - b_z * b_z));
    for (int i = 0; i < 3; i++) {
        f_g[i] = down[i] - k * f[i];
        f_b[i] = b_x * north[i] + b_z * down[i] - d[i];
    }
    double u_x = 2.0 * (f_g[0] + b_z * f_b[0]), u_y = 2.0 * (f_g[1] + b_z * f_b[1]), u_z = 4.0 * (f_g[2] + b_z * f_b[2]);
    double v_x = 4.0 * b_x * f_b[0], v_y = 2.0 * b_x * f_b[1], v_z = 2.0 * b_x * f_b[2];
    double g1 = q2 * u_y - q3 * u_x + q3 * v_z - q4 * v_y;
    double g2 = q4 * u_x + q1 * u_y - q2 * u_z + q3 * v_y + q4 * v_z;
    double g3 = q4 * u_y - q1 * u_x - q3 * u_z - q3 * v_x + q2 * v_y + q1 * v_z;
    double g4 = q2 * u_x + q3 * u_y - q4 * v_x - q1 * v_y + q2 * v_z;
    double slope = sqrt(g1 * g1 + g2 * g2 + g3 * g3 + g4 * g4);
    double down_by = slope >= 1e-9 ? beta * dt / slope : 0.0;
    q1 -= down_by * g1;
    q2 -= down_by * g2;
    q3 -= down_by * g3;
    q4 -= down_by * g4;
    double n = 1.0 / sqrt(q1 * q1 + q2 * q2 + q3 * q3 + q4 * q4);
    q[0] = n * q1;
    q[1] = n * q2;
    q[2] = n * q3;
    q[3] = n * q4;
}

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

int main(void)
{
    for (int i = 0; i < SAMPLES; i++) {
        if (scanf("%lf %lf %lf %lf %lf %lf %lf %lf %lf", &gyro[i][0], &gyro[i][1], &gyro[i][2], &accel[i][0],
                  &accel[i][1], &accel[i][2], &mag[i][0], &mag[i][1], &mag[i][2]) != 9)
            return 1;
    }
    double best = 1e18, q[4] = {1.0, 0.0, 0.0, 0.0}, f_g[3], f_b[3];
    for (int i = 0; i < SAMPLES; i++)
        step(q, f_g, f_b, gyro[i], accel[i], mag[i], 0.01, 0.033);
    printf("%.17g %.17g %.17g %.17g\n", q[0], q[1], q[2], q[3]);
    for (int block = 0; block < BLOCKS; block++) {
        double start = now_ns();
        for (int i = 0; i < STEPS; i++) {
            int j = i % SAMPLES;
            step(q, f_g, f_b, gyro[j], accel[j], mag[j], 0.01, 0.033);
        }
        best = fmin(best, (now_ns() - start) / STEPS);
    }
    printf("%.3f\n", best);
    return q[0] == q[0] ? 0 : 1; /* the attitude is used: the loop cannot be left out */
}
