/* The leveling step of attest_mav/filters/leveling.py in C, timed by tools/bench_filters: moving model with a fresh
   speed of 15 m/s and side-slip rows at every sample, unit-length row at every fifth, latitude 0.6 rad.

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
#define PI 3.14159265358979323846
#define EARTH 7.292115e-5
#define LATITUDE 0.6
#define SPEED 15.0

static double gyro[SAMPLES][3], accel[SAMPLES][3], mag[SAMPLES][3];

typedef double Mat[3][3];

typedef struct {
    double v[3], a[3]; /* velocity, down */
    Mat vv, va, aa;
    double north[3], heading_variance, q[4], waited_s, innovation[4], tilt_sigma, heading_sigma;
    int moving;
} State;

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static double norm(const double *a) { return sqrt(dot(a, a)); }

static void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void times_vec(Mat m, const double *v, double *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = dot(m[i], v);
}

static void t_times_vec(Mat m, const double *v, double *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = m[0][i] * v[0] + m[1][i] * v[1] + m[2][i] * v[2];
}

static void times(Mat a, Mat b, Mat out)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
}

static void times_t(Mat a, Mat b, Mat out)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] = dot(a[i], b[j]);
}

static void add(Mat a, Mat b)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            a[i][j] += b[i][j];
}

static void minus_outer(Mat m, const double *u, const double *v)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[i][j] -= u[i] * v[j];
}

static void symmetric(Mat m)
{
    for (int i = 0; i < 3; i++)
        for (int j = i + 1; j < 3; j++)
            m[i][j] = m[j][i] = 0.5 * (m[i][j] + m[j][i]);
}

static void axes_turn(const double *w, double dt, double gain, Mat m)
{
    double x = dt * w[0], y = dt * w[1], z = dt * w[2];
    double xx = x * x, yy = y * y, zz = z * z, t2 = xx + yy + zz, a, b;
    if (t2 < 0.01) {
        a = 1.0 - t2 * (1.0 / 6.0 - t2 * (1.0 / 120.0 - t2 * (1.0 / 5040.0 - t2 * (1.0 / 362880.0))));
        b = 0.5 - t2 * (1.0 / 24.0 - t2 * (1.0 / 720.0 - t2 * (1.0 / 40320.0 - t2 * (1.0 / 3628800.0))));
    } else {
        double t = sqrt(t2);
        a = sin(t) / t;
        b = (1.0 - cos(t)) / t2;
    }
    m[0][0] = gain * (1.0 - b * (yy + zz)), m[0][1] = gain * (b * x * y + a * z), m[0][2] = gain * (b * x * z - a * y);
    m[1][0] = gain * (b * x * y - a * z), m[1][1] = gain * (1.0 - b * (xx + zz)), m[1][2] = gain * (b * y * z + a * x);
    m[2][0] = gain * (b * x * z + a * y), m[2][1] = gain * (b * y * z - a * x), m[2][2] = gain * (1.0 - b * (xx + yy));
}

static void predict(State *s, const double *w, const double *earth, const double *f, double dt)
{
    double plus[3], minus[3], once[3], twice[3], av[3], ba[3], down[3];
    Mat a, b, d, m_v, m_d, t;
    for (int i = 0; i < 3; i++) {
        plus[i] = w[i] + earth[i];
        minus[i] = w[i] - earth[i];
    }
    axes_turn(plus, dt, 1.0, a);
    axes_turn(w, dt, G * dt, b);
    axes_turn(minus, dt, 1.0, d);
    cross(plus, f, once);
    cross(plus, once, twice);
    times_vec(a, s->v, av);
    times_vec(b, s->a, ba);
    times_vec(d, s->a, down);
    for (int i = 0; i < 3; i++) {
        s->v[i] = av[i] + ba[i] + dt * (f[i] - dt * (0.5 * once[i] - dt / 6.0 * twice[i]));
        s->a[i] = down[i];
    }
    times(a, s->vv, m_v);
    times_t(b, s->va, t);
    add(m_v, t);
    times(a, s->va, m_d);
    times(b, s->aa, t);
    add(m_d, t);
    times_t(m_v, a, s->vv);
    times_t(m_d, b, t);
    add(s->vv, t);
    symmetric(s->vv);
    times_t(m_d, d, s->va);
    times(d, s->aa, t);
    times_t(t, d, s->aa);
    symmetric(s->aa);
    for (int i = 0; i < 3; i++) {
        s->vv[i][i] += 1e-3 * dt;
        s->aa[i][i] += 1e-5 * dt;
    }
}

static void correct(State *s, const double *h_v, const double *h_a, double z, double r)
{
    double g_v[3], g_a[3], w_v[3], w_a[3], k_v[3], k_a[3], t[3];
    times_vec(s->vv, h_v, g_v);
    times_vec(s->va, h_a, t);
    for (int i = 0; i < 3; i++)
        g_v[i] += t[i];
    t_times_vec(s->va, h_v, g_a);
    times_vec(s->aa, h_a, t);
    for (int i = 0; i < 3; i++)
        g_a[i] += t[i];
    double share = 1.0 / (dot(h_v, g_v) + dot(h_a, g_a) + r);
    for (int i = 0; i < 3; i++) {
        k_v[i] = share * g_v[i];
        k_a[i] = share * g_a[i];
        s->v[i] += k_v[i] * z;
        s->a[i] += k_a[i] * z;
    }
    minus_outer(s->vv, k_v, g_v);
    minus_outer(s->va, k_v, g_a);
    minus_outer(s->aa, k_a, g_a);
    times_vec(s->vv, h_v, w_v);
    times_vec(s->va, h_a, t);
    for (int i = 0; i < 3; i++)
        w_v[i] += t[i] - r * k_v[i];
    t_times_vec(s->va, h_v, w_a);
    times_vec(s->aa, h_a, t);
    for (int i = 0; i < 3; i++)
        w_a[i] += t[i] - r * k_a[i];
    minus_outer(s->vv, w_v, k_v);
    minus_outer(s->va, w_v, k_a);
    minus_outer(s->aa, w_a, k_a);
    symmetric(s->vv);
    symmetric(s->aa);
}

static void unit(double *v)
{
    double k = 1.0 / norm(v);
    for (int i = 0; i < 3; i++)
        v[i] *= k;
}

static void across(double *v, const double *axis)
{
    double along = dot(v, axis);
    for (int i = 0; i < 3; i++)
        v[i] -= along * axis[i];
}

static void quaternion(const double *n, const double *d, const double *before, double *q)
{
    double e[3], k = 0.0, sign = 0.0;
    cross(d, n, e);
    double trace = n[0] + e[1] + d[2];
    double c[4][4] = {{1.0 + trace, d[1] - e[2], n[2] - d[0], e[0] - n[1]},
                      {d[1] - e[2], 1.0 + n[0] - e[1] - d[2], n[1] + e[0], n[2] + d[0]},
                      {n[2] - d[0], n[1] + e[0], 1.0 - n[0] + e[1] - d[2], e[2] + d[1]},
                      {e[0] - n[1], n[2] + d[0], e[2] + d[1], 1.0 - n[0] - e[1] + d[2]}};
    int row = 0;
    for (int i = 1; i < 4; i++)
        if (c[i][i] > c[row][row])
            row = i;
    for (int i = 0; i < 4; i++)
        k += c[row][i] * c[row][i];
    for (int i = 0; i < 4; i++)
        sign += c[row][i] * before[i];
    k = (sign >= 0.0 ? 1.0 : -1.0) / sqrt(k);
    for (int i = 0; i < 4; i++)
        q[i] = k * c[row][i];
}

static void turn_right(double *north, const double *down, double angle)
{
    double east[3], c = cos(angle), s = sin(angle);
    cross(down, north, east);
    for (int i = 0; i < 3; i++)
        north[i] = c * north[i] + s * east[i];
}

static void follow_field(State *s, const double *down, const double *m, double dt)
{
    double level[3] = {m[0], m[1], m[2]}, east[3];
    s->heading_variance += 1e-5 * dt;
    across(level, down);
    if (norm(level) < 0.1 * norm(m))
        return;
    cross(down, s->north, east);
    double gain = fmin(dt, 0.05) / 5.0;
    s->heading_variance = (1.0 - gain) * (1.0 - gain) * s->heading_variance + gain * gain * 2.7e-3;
    turn_right(s->north, down, gain * atan2(dot(east, level), dot(s->north, level)));
}

static double tilt_variance(State *s)
{
    double t[3], length_sq = dot(s->a, s->a);
    times_vec(s->aa, s->a, t);
    double variance = (s->aa[0][0] + s->aa[1][1] + s->aa[2][2] - dot(s->a, t) / length_sq) / length_sq;
    return fmin(fmax(variance, 0.0), PI * PI);
}

static State step(const State *before, const double *w, const double *f, const double *m, double dt)
{
    static const double axis[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, zero[3] = {0.0, 0.0, 0.0};
    State s = *before;
    const double *q = before->q;
    double down[3] = {2.0 * (q[1] * q[3] - q[0] * q[2]), 2.0 * (q[2] * q[3] + q[0] * q[1]),
                      q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]};
    double earth[3], minus[3], two_a[3];
    for (int i = 0; i < 3; i++)
        earth[i] = EARTH * (cos(LATITUDE) * s.north[i] - sin(LATITUDE) * down[i]);
    predict(&s, w, earth, f, dt);

    if (!s.moving) {
        memset(s.vv, 0, sizeof s.vv);
        memset(s.va, 0, sizeof s.va);
        for (int i = 0; i < 3; i++) {
            s.v[i] = i == 0 ? SPEED : 0.0;
            s.vv[i][i] = 1.0;
        }
        s.moving = 1;
    }
    for (int i = 0; i < 3; i++) {
        s.innovation[i] = (i == 0 ? SPEED : 0.0) - s.v[i];
        correct(&s, axis[i], zero, s.innovation[i], i == 0 ? 0.01 : 0.09);
    }
    s.waited_s += dt;
    s.innovation[3] = NAN;
    if (s.waited_s > 0.05 - 0.5 * dt) {
        double largest = fmax(s.aa[0][0], fmax(s.aa[1][1], s.aa[2][2]));
        s.waited_s = 0.0;
        s.innovation[3] = 1.0 - dot(s.a, s.a);
        for (int i = 0; i < 3; i++)
            two_a[i] = 2.0 * s.a[i];
        correct(&s, zero, two_a, s.innovation[3], largest < 0.0025 ? 0.1 : 0.7);
    }

    Mat turn;
    for (int i = 0; i < 3; i++) {
        minus[i] = w[i] - earth[i];
        down[i] = s.a[i];
    }
    unit(down);
    axes_turn(minus, dt, 1.0, turn);
    times_vec(turn, before->north, s.north);
    across(s.north, down);
    unit(s.north);
    follow_field(&s, down, m, dt);
    quaternion(s.north, down, before->q, s.q);
    for (int i = 0; i < 3; i++) {
        s.vv[i][i] = fmax(s.vv[i][i], 1e-12);
        s.aa[i][i] = fmax(s.aa[i][i], 1e-12);
    }
    s.tilt_sigma = sqrt(tilt_variance(&s));
    s.heading_sigma = sqrt(s.heading_variance);
    return s;
}

static State start(void)
{
    State s;
    memset(&s, 0, sizeof s);
    s.q[0] = s.a[2] = s.north[0] = 1.0;
    s.heading_variance = 2.7e-3;
    s.waited_s = 0.05;
    for (int i = 0; i < 3; i++) {
        s.vv[i][i] = 1.0;
        s.aa[i][i] = 0.05;
    }
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
