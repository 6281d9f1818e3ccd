/* The robust adaptive step of attest_mav/filters/robust_adaptive.py in C, timed by tools/bench_filters.

   Reads 500 samples of nine numbers. Prints the attitude after one pass over them, so that it can be compared, and
   the best time of 30 blocks of 20,000 steps, in nanoseconds a step. */

#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define SAMPLES 500
#define BLOCKS 30
#define STEPS 20000
#define G 9.80665

static double gyro[SAMPLES][3], accel[SAMPLES][3], mag[SAMPLES][3];

typedef struct {
    double q[4], p[4][4], innovation[4], inflation[4], alpha, disagreement, rejected_s[4], tilt_sigma, heading_sigma;
} State;

static const double R[4] = {1e-3, 1e-3, 1e-3, 2.7e-3};

static double norm3(const double *v) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static void multiply(const double *a, const double *b, double *out)
{
    double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    out[0] = w, out[1] = x, out[2] = y, out[3] = z;
}

static void normalise(double *q)
{
    double k = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++)
        q[i] *= k;
}

static double dot4(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

static double quadratic(double p[4][4], const double *h)
{
    double sum = 0.0;
    for (int i = 0; i < 4; i++)
        sum += h[i] * dot4(p[i], h);
    return sum;
}

static void turn_rows(double p[4][4], const double *turn)
{
    double t[4][4];
    for (int i = 0; i < 4; i++)
        multiply(p[i], turn, t[i]);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            p[i][j] = t[j][i];
}

static void correct(double p[4][4], const double *h, double r, double *k)
{
    double g[4], rest[4];
    for (int i = 0; i < 4; i++)
        g[i] = dot4(p[i], h);
    double share = 1.0 / (dot4(h, g) + r);
    for (int i = 0; i < 4; i++)
        k[i] = share * g[i];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            p[i][j] -= k[i] * g[j];
    for (int i = 0; i < 4; i++)
        rest[i] = r * k[i] - dot4(p[i], h);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            p[i][j] += rest[i] * k[j];
}

static void weigh(double z, double variance, double rejected_s, double dt, double *inflation, double *waited)
{
    double size = fabs(z) / sqrt(variance);
    if (isnan(z))
        *inflation = INFINITY, *waited = rejected_s;
    else if (size <= 1.5)
        *inflation = 1.0, *waited = 0.0;
    else if (rejected_s >= 5.0)
        *inflation = 1.0, *waited = rejected_s;
    else if (size < 6.0)
        *inflation = size / 1.5, *waited = 0.0;
    else
        *inflation = INFINITY, *waited = rejected_s + dt;
}

static void measure(const double *q, const double *f, const double *m, double *z)
{
    double w = q[0], x = q[1], y = q[2], v = q[3];
    double north[3] = {w * w + x * x - y * y - v * v, 2.0 * (x * y - w * v), 2.0 * (x * v + w * y)};
    double east[3] = {2.0 * (x * y + w * v), w * w - x * x + y * y - v * v, 2.0 * (y * v - w * x)};
    double down[3] = {2.0 * (x * v - w * y), 2.0 * (y * v + w * x), w * w - x * x - y * y + v * v};
    double f_norm = norm3(f), m_north = 0.0, m_east = 0.0;
    int usable = fabs(f_norm / G - 1.0) <= 0.3;
    for (int i = 0; i < 3; i++) {
        z[i] = usable ? f[i] / f_norm + down[i] : NAN;
        m_north += north[i] * m[i];
        m_east += east[i] * m[i];
    }
    z[3] = sqrt(m_north * m_north + m_east * m_east) > 0.1 * norm3(m) ? -atan2(m_east, m_north) : NAN;
}

static State step(const State *before, const double *omega, const double *f, const double *m, double dt)
{
    State s = *before;
    double u[3] = {0.5 * dt * omega[0], 0.5 * dt * omega[1], 0.5 * dt * omega[2]};
    double sq = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], c, k;
    if (sq < 1e-3) {
        c = 1.0 - sq * (0.5 - sq * (1.0 / 24.0 - sq * (1.0 / 720.0)));
        k = 1.0 - sq * (1.0 / 6.0 - sq * (1.0 / 120.0 - sq * (1.0 / 5040.0)));
    } else {
        double angle = sqrt(sq);
        c = cos(angle);
        k = sin(angle) / angle;
    }
    double turn[4] = {c, k * u[0], k * u[1], k * u[2]};
    multiply(before->q, turn, s.q);
    normalise(s.q);
    turn_rows(s.p, turn);
    turn_rows(s.p, turn);
    double noise = 0.25 * 2.7e-7 * dt;
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++)
            s.p[i][j] -= noise * s.q[i] * s.q[j];
        s.p[i][i] += noise;
    }

    double w = s.q[0], x = s.q[1], y = s.q[2], z = s.q[3];
    double h[4][4] = {{2.0 * y, -2.0 * z, 2.0 * w, -2.0 * x},
                      {-2.0 * x, -2.0 * w, -2.0 * z, -2.0 * y},
                      {-2.0 * w, 2.0 * x, 2.0 * y, -2.0 * z},
                      {-2.0 * z, -2.0 * y, 2.0 * x, 2.0 * w}};
    double total = 0.0, count = 0.0, largest = 0.0;
    measure(s.q, f, m, s.innovation);
    for (int i = 0; i < 4; i++) {
        double variance = quadratic(s.p, h[i]) + R[i];
        weigh(s.innovation[i], variance, before->rejected_s[i], dt, &s.inflation[i], &s.rejected_s[i]);
        if (s.inflation[i] == 1.0) {
            total += s.innovation[i] * s.innovation[i] / variance;
            count += 1.0;
        }
        largest = fmax(largest, s.p[i][i]);
    }
    s.alpha = 1.0;
    if (count > 0.0) {
        s.disagreement += fmin(1.0, fmin(dt, 0.05) / 0.5) * (total / count - s.disagreement);
        if (s.disagreement > 2.0)
            s.alpha = fmax(0.2, 2.0 / s.disagreement);
    }
    s.alpha = fmax(s.alpha, fmin(1.0, largest));
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            s.p[i][j] /= s.alpha;

    double dq[4] = {0.0, 0.0, 0.0, 0.0}, gain[4];
    for (int i = 0; i < 4; i++) {
        if (isinf(s.inflation[i]))
            continue;
        correct(s.p, h[i], s.inflation[i] * R[i], gain);
        double rest = s.innovation[i] - dot4(h[i], dq);
        for (int j = 0; j < 4; j++)
            dq[j] += gain[j] * rest;
    }
    for (int i = 0; i < 4; i++) {
        s.q[i] += dq[i];
        for (int j = i + 1; j < 4; j++)
            s.p[i][j] = s.p[j][i] = 0.5 * (s.p[i][j] + s.p[j][i]);
        s.p[i][i] = fmax(s.p[i][i], 1e-14);
    }
    normalise(s.q);
    double a = s.q[0], b = s.q[1], d = s.q[2], e = s.q[3];
    double n[4] = {-2.0 * b, 2.0 * a, -2.0 * e, 2.0 * d}, o[4] = {-2.0 * d, 2.0 * e, 2.0 * a, -2.0 * b};
    double v[4] = {-2.0 * e, -2.0 * d, 2.0 * b, 2.0 * a};
    s.tilt_sigma = sqrt(fmax(quadratic(s.p, n) + quadratic(s.p, o), 0.0));
    s.heading_sigma = sqrt(fmax(quadratic(s.p, v), 0.0));
    return s;
}

static State start(void)
{
    State s;
    memset(&s, 0, sizeof s);
    s.q[0] = s.alpha = s.disagreement = 1.0;
    for (int i = 0; i < 4; i++)
        s.p[i][i] = 1e-4;
    return s;
}

int main(void)
{
    for (int k = 0; k < SAMPLES; k++)
        if (scanf("%lf%lf%lf%lf%lf%lf%lf%lf%lf", gyro[k], gyro[k] + 1, gyro[k] + 2, accel[k], accel[k] + 1,
                  accel[k] + 2, mag[k], mag[k] + 1, mag[k] + 2) != 9)
            return 1;
    State s = start();
    for (int k = 0; k < SAMPLES; k++)
        s = step(&s, gyro[k], accel[k], mag[k], 0.01);
    printf("%.17g %.17g %.17g %.17g\n", s.q[0], s.q[1], s.q[2], s.q[3]);
    double best = 1e300;
    for (int block = 0; block < BLOCKS; block++) {
        struct timespec from, to;
        clock_gettime(CLOCK_MONOTONIC, &from);
        s = start();
        for (int k = 0; k < STEPS; k++)
            s = step(&s, gyro[k % SAMPLES], accel[k % SAMPLES], mag[k % SAMPLES], 0.01);
        clock_gettime(CLOCK_MONOTONIC, &to);
        best = fmin(best, ((to.tv_sec - from.tv_sec) * 1e9 + (to.tv_nsec - from.tv_nsec)) / STEPS);
    }
    printf("%.3f\n", best);
    return s.q[0] == s.q[0] ? 0 : 1; /* the attitude is used: the loop cannot be left out */
}
