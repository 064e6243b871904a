/* The default method for one straight line, as C is written: one run at a time, everything in the first
   cache. REAL is float or double.

   A line of n equal segments, fixed at its start, loaded at its end by a force that dies away as cos^2.
   Tanh law without compression; quadratic drag at mid-step; dispersion correction and limited viscosity. */

#include <float.h>
#include <math.h>
#include <stdlib.h>
#if defined FLUSH && defined __SSE__
#include <xmmintrin.h>
#define DENORMALS_OFF const unsigned kept = _mm_getcsr(); _mm_setcsr(kept | 0x8040)
#define AS_BEFORE _mm_setcsr(kept)
#else
#define DENORMALS_OFF
#define AS_BEFORE
#endif

#ifndef REAL
#define REAL double
#endif

typedef struct {
    REAL p1, p2, p3, p4, p5;   /* the law (N) */
    REAL length, mass, drag;   /* segment (m), kg/m, N s2/m3 */
    REAL strain, hold;         /* before the break (-, N) */
    REAL time;                 /* of the break (s) */
} Line;

static inline REAL least(REAL a, REAL b) { return a < b ? a : b; }
static inline REAL most(REAL a, REAL b) { return a > b ? a : b; }

/* Moves one line by `steps` of dt (s); u (m) and v (m/s) have n + 1 nodes. Returns the top speed of the end. */
static REAL move(const Line *p, int n, long steps, REAL dt, REAL *restrict u, REAL *restrict v,
                 REAL *restrict room) {
    REAL *restrict tension = room + 8;       /* one ghost on either side of each of these */
    REAL *restrict jump = tension + n + 16;
    REAL *restrict nu2 = jump + n + 16;
    REAL *restrict carried = nu2 + n + 16;
    const REAL l = p->length, m = p->mass, back = 1 / l, rest = (REAL)0.25 * l / dt;
    const REAL squared = dt * dt / (l * l * m), share = l / dt / 6;
    const REAL twice = 2 * m * l / dt, resist = 4 * p->drag * l;
    const REAL eps = sizeof(REAL) == 8 ? (REAL)DBL_EPSILON : (REAL)FLT_EPSILON;
    const REAL noise = 50 * eps, next_to = sqrt(eps);
    REAL peak = 0;
    for (long k = 1; k <= steps; k++) {
        const REAL t = k * dt;
        const int holds = t < p->time;
        const REAL turn = (REAL)1.5707963267948966 / p->time;
        const REAL c = holds ? cos(turn * t) : 0, s = holds ? sin(turn * t) : 0;
        const REAL hold = p->hold * c * c, fades = holds ? -2 * turn * p->hold * c * s : 0;
        for (int i = 0; i <= n; i++) u[i] += dt * v[i];
        for (int j = 0; j < n; j++) {
            const REAL e = p->strain + (u[j + 1] - u[j]) * back;
            const REAL h = tanh(p->p2 * e + p->p3);
            const REAL T = p->p1 * h + p->p4 + p->p5 * e;
            const REAL K = p->p1 * p->p2 * (1 - h * h) + p->p5;
            tension[j] = T > 0 ? T : 0;
            nu2[j] = (T > 0 ? K : 0) * squared;
            jump[j] = v[j + 1] - v[j];
        }
        tension[-1] = tension[0]; jump[-1] = jump[0];
        tension[n] = 2 * hold - tension[n - 1];
        /* the loaded end's own strain rate is what its force asks for: the mean of the two beside it */
        const REAL stiff = nu2[n - 1] / squared;
        int fallen = 1;
        REAL fastest = 0;
        for (int j = most(n - 5, 0); j < n; j++) {
            fallen &= nu2[j] <= 0;
            fastest = least(fastest, jump[j]);
        }
        /* or a wave shortens the last ones alike, and the end's own is slack */
        fallen |= n >= 5 && nu2[n - 1] <= 0 && jump[n - 1] <= fastest / 5 &&
                  jump[n - 2] <= fastest / 4 && jump[n - 3] <= fastest / 3;
        jump[n] = fallen ? jump[n - 1] : (stiff > 0 ? 2 * l * fades / stiff : 0) - jump[n - 1];
        nu2[n] = nu2[n - 1]; nu2[-1] = nu2[0];
        for (int j = 0; j < n; j++) {
            const REAL D = jump[j], T = tension[j];
            const REAL speed = sqrt(nu2[j] / squared / m);
            const REAL beside = most(fabs(jump[j - 1]), fabs(jump[j + 1]));
            const int still = fabs(D) <= most(noise * speed, next_to * beside);
            const REAL inverse = 1 / (still ? 1 : D);
            const REAL rl = jump[j - 1] * inverse, rr = jump[j + 1] * inverse;
            const REAL less = T > 0 && D < 0 ? 1 : least(2 * rl, 2 * rr);
            REAL phi = least((REAL)0.5 * (rl + rr), less);
            phi = still ? 1 : least(most(phi, 0), 1);
            const REAL f = (1 - phi) * (1 - phi);
            const REAL more = j == n - 1 ? (REAL)1.5 : 1, part = j == n - 1 ? (REAL)0.14 : (REAL)0.4;
            const REAL limit = most(part * share * (1 - nu2[j]) * (3 - nu2[j]), 0);
            REAL b = least(more * ((REAL)0.16 * speed + (REAL)0.5 * fabs(D)), limit);
            const REAL left = most(1 - most(nu2[j - 1], nu2[j + 1]), 0) * (REAL)0.3 * 4 * rest;
            const REAL slack = D > 0 ? rest : least(rest, left);
            b = T > 0 ? b : slack;
            const REAL bend = tension[j + 1] - 2 * T + tension[j - 1];
            const REAL correction = (f - 1) * (1 - nu2[j]) * (REAL)(1.0 / 12) * bend;
            carried[j] = T + most(correction, -T) + m * b * D * f;
        }
        carried[n] = hold;
        const REAL outer = v[n];
        for (int i = 1; i <= n; i++) {
            const REAL weight = i == n ? (REAL)0.5 : 1;
            const REAL a = weight * twice, b = carried[i] - carried[i - 1] + a * v[i];
            const REAL middle = 2 * b / (a + sqrt(a * a + weight * resist * fabs(b)));
            v[i] = 2 * middle - v[i];
        }
        const REAL q = least(most(nu2[n - 1], 0), 1);
        /* what the tensions do to the end's half mass, less what they do to its neighbour */
        const REAL ahead = 2 * (hold - carried[n - 1]) - (carried[n - 1] - carried[n - 2]);
        v[n] += (REAL)0.25 * (1 - q) * ahead * dt / (m * l);
        peak = most(peak, fabs((REAL)0.5 * (v[n] + outer)));
    }
    return peak;
}

/* `runs` lines one after the other; strains and holding forces differ. u and v are (runs, n + 1).
   Velocities start half a step in, from the force of the first instant, as leapfrog's do. */
void run(const Line *line, int runs, const REAL *strain, const REAL *hold, int n, long steps, REAL dt,
         REAL *u, REAL *v, REAL *peak) {
    DENORMALS_OFF;
    REAL *room = calloc(4 * (n + 16) + 16, sizeof(REAL));
    for (int r = 0; r < runs; r++) {
        Line mine = *line;
        mine.strain = strain[r];
        mine.hold = hold[r];
        peak[r] = move(&mine, n, steps, dt, u + (long)r * (n + 1), v + (long)r * (n + 1), room);
    }
    free(room);
    AS_BEFORE;
}
