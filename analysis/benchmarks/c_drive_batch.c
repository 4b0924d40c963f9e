/* Many C-drives under PD at once: LANES parameter sets side by side, each sample of all before the next.
 *
 * The laws of c_drive_loop.c with exact encoders. The compiler turns each loop over lanes into vector
 * instructions, tanh included (libmvec); blocks of lanes go to the OpenMP threads.
 */
#include <math.h>

enum { LANES = 16 };

typedef struct {
    double m11[LANES], m12[LANES], beta[LANES], gamma[LANES], delta[LANES], eta[LANES];
} machines;

typedef struct {
    double width, kp, kd, cutoff, dt;
} loop;

#define SLOPE(vl, vr, tl, tr, al, ar)                                                              \
    do {                                                                                           \
        const double p = (vl), q = (vr), slip = p - q;                                             \
        const double collar = 0.5 * m.gamma[i] * slip + m.eta[i] * tanh(slip / c.width);           \
        const double l = (tl) - m.beta[i] * p - m.delta[i] * tanh(p / c.width) - collar;           \
        const double r = (tr) - m.beta[i] * q - m.delta[i] * tanh(q / c.width) + collar;           \
        const double det = m.m11[i] * m.m11[i] - m.m12[i] * m.m12[i];                              \
        al = (m.m11[i] * l - m.m12[i] * r) / det;                                                  \
        ar = (m.m11[i] * r - m.m12[i] * l) / det;                                                  \
    } while (0)

static void block(int samples, const double *reference, const machines *restrict all, loop c,
                  double *restrict squares)
{
    double ql[LANES] = {0}, qr[LANES] = {0}, vl[LANES] = {0}, vr[LANES] = {0};
    double low_l[LANES] = {0}, low_r[LANES] = {0}, sum[LANES] = {0};
    const machines m = *all;
    const double decay = exp(-c.cutoff * c.dt), h = c.dt;
    for (int k = 0; k < samples; k++) {
        const double rl = reference[2 * k], rr = reference[2 * k + 1];
#pragma omp simd
        for (int i = 0; i < LANES; i++) {
            const double el = rl - ql[i], er = rr - qr[i], x = vl[i], y = vr[i];
            const double tl = c.kp * el + c.kd * c.cutoff * (el - low_l[i]);
            const double tr = c.kp * er + c.kd * c.cutoff * (er - low_r[i]);
            double a1, b1, a2, b2, a3, b3, a4, b4;
            low_l[i] = el + decay * (low_l[i] - el);
            low_r[i] = er + decay * (low_r[i] - er);
            sum[i] += el * el + er * er;
            SLOPE(x, y, tl, tr, a1, b1);
            SLOPE(x + 0.5 * h * a1, y + 0.5 * h * b1, tl, tr, a2, b2);
            SLOPE(x + 0.5 * h * a2, y + 0.5 * h * b2, tl, tr, a3, b3);
            SLOPE(x + h * a3, y + h * b3, tl, tr, a4, b4);
            ql[i] += h * x + h * h / 6 * (a1 + a2 + a3);
            qr[i] += h * y + h * h / 6 * (b1 + b2 + b3);
            vl[i] += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
            vr[i] += h / 6 * (b1 + 2 * b2 + 2 * b3 + b4);
        }
    }
    for (int i = 0; i < LANES; i++)
        squares[i] = sum[i];
}

/* table: sets x 6, the order of `machines`; rms: tracking error [rad] of each set over both shafts. */
void c_drive_batch(int sets, int samples, const double *reference, const double *table,
                   const double *constants, double *rms)
{
    const loop c = {constants[0], constants[1], constants[2], constants[3], constants[4]};
#pragma omp parallel for schedule(static)
    for (int first = 0; first < sets; first += LANES) {
        machines m;
        double squares[LANES];
        for (int i = 0; i < LANES; i++) {
            const double *row = table + 6 * (first + i < sets ? first + i : sets - 1);
            m.m11[i] = row[0], m.m12[i] = row[1], m.beta[i] = row[2];
            m.gamma[i] = row[3], m.delta[i] = row[4], m.eta[i] = row[5];
        }
        block(samples, reference, &m, c, squares);
        for (int i = 0; i < LANES && first + i < sets; i++)
            rms[first + i] = sqrt(squares[i] / (2.0 * samples));
    }
}
