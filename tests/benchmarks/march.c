/* The loop of gearfem/dynamics/kernels.py while contact lasts or is absent, written again: same tables, same formula.
   A step whose contact state would change ends the run: returns the number of whole steps done. */
#include <stddef.h>

typedef struct { double x2, w2, force; } Push;

static inline Push push(const double *restrict motion, const double *restrict table, const double *restrict knots, ptrdiff_t last, double damp, double brake,
                        double play, ptrdiff_t point, double x, double v, int side, ptrdiff_t *cell)
{
    const double *m = motion + 4 * point;
    Push p = {m[2] + brake, m[3], 0.0};
    if (side == 0) return p;
    double depth = x + m[0], speed = v + m[1];
    if (side < 0) { depth = -depth - play; speed = -speed; }
    double inside = depth > 0.0 ? depth : 0.0;
    if (inside > knots[last + 1]) inside = knots[last + 1];
    while (*cell > 0 && inside < knots[*cell]) --*cell;
    while (*cell < last && inside >= knots[*cell + 1]) ++*cell;
    double s = inside - knots[*cell];
    const double *c = table + 20 * ((last + 1) * point + *cell);
    double force = ((c[3] * s + c[2]) * s + c[1]) * s + c[0];
    if (depth != inside) force += ((3.0 * c[3] * s + 2.0 * c[2]) * s + c[1]) * (depth - inside);
    const double *n = side > 0 ? c + 4 : c + 12;
    double both = ((n[3] * s + n[2]) * s + n[1]) * s + n[0];
    double one = ((n[7] * s + n[6]) * s + n[5]) * s + n[4];
    force += damp * speed;
    p.x2 -= force * both;
    p.w2 -= force * one;
    p.force = force;
    return p;
}

ptrdiff_t march(const double *steps, const ptrdiff_t *first, ptrdiff_t count, const double *restrict motion, const double *restrict table,
                const double *restrict knots, ptrdiff_t cells, double damp, double brake, double play, double *state, int side, ptrdiff_t cycles)
{
    double x = state[0], v = state[1], w = state[2];
    ptrdiff_t last = cells - 1, cell = 0, done = 0;
    for (ptrdiff_t cycle = 0; cycle < cycles; ++cycle)
        for (ptrdiff_t step = 0; step < count; ++step, ++done) {
            ptrdiff_t p = first[step];
            double h = steps[step];
            Push a = push(motion, table, knots, last, damp, brake, play, p, x, v, side, &cell);
            double v2 = v + 0.5 * h * a.x2;
            Push b = push(motion, table, knots, last, damp, brake, play, p + 1, x + 0.5 * h * v, v2, side, &cell);
            double v3 = v + 0.5 * h * b.x2;
            Push c = push(motion, table, knots, last, damp, brake, play, p + 1, x + 0.5 * h * v2, v3, side, &cell);
            double v4 = v + h * c.x2;
            Push d = push(motion, table, knots, last, damp, brake, play, p + 2, x + h * v3, v4, side, &cell);
            double nx = x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), nv = v + h / 6.0 * (a.x2 + 2.0 * (b.x2 + c.x2) + d.x2);
            double nw = w + h / 6.0 * (a.w2 + 2.0 * (b.w2 + c.w2) + d.w2);
            double depth = nx + motion[4 * (p + 2)];
            if (side ? push(motion, table, knots, last, damp, brake, play, p + 2, nx, nv, side, &cell).force < 0.0
                     : depth > 0.0 || depth < -play)
                goto end;
            x = nx; v = nv; w = nw;
        }
end:
    state[0] = x; state[1] = v; state[2] = w;
    return done;
}
