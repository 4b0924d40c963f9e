/* The C-drive under PD, written by hand for this one machine: the limit that loops are measured against.
 *
 * Independent of models/: no matrices, no loops over shafts. M [vL' vR'] = [tL tR] - friction; dry
 * friction is level * tanh(speed / width) of each motor and of the collar, whose speed is vL - vR.
 */
#include <math.h>

typedef struct {
    double m11, m12, beta, gamma, delta, eta, width; /* machine */
    double kp, kd, cutoff, dt, lsb;                  /* controller, sample time, encoder step */
} constants;

static inline double rub(double v, double viscous, double level, double width)
{
    return viscous * v + level * tanh(v / width);
}

static inline double encoder(double q, double lsb)
{
    return lsb > 0 ? lsb * floor(q / lsb + 0.5) : q;
}

static inline void slope(const constants *c, double vl, double vr, double tl, double tr, double *al,
                         double *ar)
{
    const double collar = rub(vl - vr, 0.5 * c->gamma, c->eta, c->width);
    const double l = tl - rub(vl, c->beta, c->delta, c->width) - collar;
    const double r = tr - rub(vr, c->beta, c->delta, c->width) + collar;
    const double det = c->m11 * c->m11 - c->m12 * c->m12;
    *al = (c->m11 * l - c->m12 * r) / det;
    *ar = (c->m11 * r - c->m12 * l) / det;
}

/* reference, measured, command: samples x 2, left and right in turn. */
void c_drive_loop(int samples, const double *reference, const constants *c, double *measured,
                  double *command)
{
    double ql = 0, qr = 0, vl = 0, vr = 0, low_l = 0, low_r = 0;
    const double decay = exp(-c->cutoff * c->dt), h = c->dt;
    for (int k = 0; k < samples; k++) {
        const double yl = encoder(ql, c->lsb), yr = encoder(qr, c->lsb);
        const double el = reference[2 * k] - yl, er = reference[2 * k + 1] - yr;
        const double tl = c->kp * el + c->kd * c->cutoff * (el - low_l);
        const double tr = c->kp * er + c->kd * c->cutoff * (er - low_r);
        low_l = el + decay * (low_l - el);
        low_r = er + decay * (low_r - er);
        measured[2 * k] = yl, measured[2 * k + 1] = yr;
        command[2 * k] = tl, command[2 * k + 1] = tr;

        double a1, b1, a2, b2, a3, b3, a4, b4;
        slope(c, vl, vr, tl, tr, &a1, &b1);
        slope(c, vl + 0.5 * h * a1, vr + 0.5 * h * b1, tl, tr, &a2, &b2);
        slope(c, vl + 0.5 * h * a2, vr + 0.5 * h * b2, tl, tr, &a3, &b3);
        slope(c, vl + h * a3, vr + h * b3, tl, tr, &a4, &b4);
        ql += h * vl + h * h / 6 * (a1 + a2 + a3);
        qr += h * vr + h * h / 6 * (b1 + b2 + b3);
        vl += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        vr += h / 6 * (b1 + 2 * b2 + 2 * b3 + b4);
    }
}
