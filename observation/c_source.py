"""The observer of one arm and model as one C99 file without dependencies: the same equations, the same filter, the same numbers."""

from collections.abc import Mapping

import numpy as np

from mechanism.laws import Law
from observation.code import c_function
from observation.expression import Expression, variable
from observation.filter_numbers import GAMMA, LAG_SIGMA_S, POSE_RATE_HZ, POSE_TIME_S
from observation.observer import (
    AT_REST_RAD,
    MAX_GAP_S,
    MAX_NEWTON_RAD,
    MAX_STEP_S,
    NEWTON_STEPS,
    RANGE_RAD,
    Observer,
)
from observation.tracing import Untraceable, elements_of, symbols
from xneck_foundation.errors import Refused

_TEMPLATE = """\
/* Joint angles of one arm from its motors' angles and forces, row by row of its controller. Written by `xneck observe --export c`.
 *
 *     xneck_observer o;
 *     xneck_observer_begin(&o, NULL);                      NULL, or the N joint angles where the arm stands, rad
 *     xneck_observer_step(&o, 0.002, theta, f);            each row: s since the row before, M motor angles, rad, M forces, N
 *     xneck_observer_frame(&o, angles, sigma);             where a camera saw the joints in that row: NAN where it did not, rad
 *     xneck_observer_read(&o, alpha, alpha_d, covariance); N, N, 2 N times 2 N
 *
 * A row further than MAX_GAP_S from the one before begins anew. Nothing is allocated; one step takes the same time as any other.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

{defines}

typedef struct {{
    double s[SIZE], P[SIZE * SIZE], speed_d[SIZE], force[M_], acting[LAWS * M_ + 1];
    double since, pose[N_];
    int running, told;
}} xneck_observer;

{constants}

static double sign_of(double x) {{ return (double)((x > 0) - (x < 0)); }}
static double power_of(double x, double p) {{ return x == 0.0 && p < 0.0 ? 0.0 : pow(x, p); }}

{functions}

static void use_all(void) {{ (void)sign_of; (void)power_of; }}

/* out (n, k) = a (n, m) b (m, k) */
static void product(const double *a, const double *b, double *out, int n, int m, int k)
{{
    for (int i = 0; i < n; i++) {{
        double *row = out + i * k;
        for (int j = 0; j < k; j++) row[j] = 0.0;
        for (int l = 0; l < m; l++) {{
            const double x = a[i * m + l];
            if (x != 0.0)
                for (int j = 0; j < k; j++) row[j] += x * b[l * k + j];
        }}
    }}
}}

/* a (n, n) x = b (n, k), by elimination with the largest pivot; a is destroyed, b becomes x. 0 where a is singular. */
static int solved(double *a, double *b, int n, int k)
{{
    for (int c = 0; c < n; c++) {{
        int best = c;
        for (int r = c + 1; r < n; r++)
            if (fabs(a[r * n + c]) > fabs(a[best * n + c])) best = r;
        if (a[best * n + c] == 0.0) return 0;
        if (best != c) {{
            for (int j = 0; j < n; j++) {{ const double t = a[c * n + j]; a[c * n + j] = a[best * n + j]; a[best * n + j] = t; }}
            for (int j = 0; j < k; j++) {{ const double t = b[c * k + j]; b[c * k + j] = b[best * k + j]; b[best * k + j] = t; }}
        }}
        for (int r = c + 1; r < n; r++) {{
            const double x = a[r * n + c] / a[c * n + c];
            if (x == 0.0) continue;
            for (int j = c; j < n; j++) a[r * n + j] -= x * a[c * n + j];
            for (int j = 0; j < k; j++) b[r * k + j] -= x * b[c * k + j];
        }}
    }}
    for (int r = n - 1; r >= 0; r--)
        for (int j = 0; j < k; j++) {{
            double x = b[r * k + j];
            for (int c = r + 1; c < n; c++) x -= a[r * n + c] * b[c * k + j];
            b[r * k + j] = x / a[r * n + r];
        }}
    return 1;
}}

static void made_symmetric(double *P)
{{
    for (int i = 0; i < SIZE; i++)
        for (int j = 0; j < i; j++) P[i * SIZE + j] = P[j * SIZE + i] = (P[i * SIZE + j] + P[j * SIZE + i]) / 2;
}}

/* rates, their derivatives by the state (RATES, SIZE), mass matrix and tensions */
static void formed(const double *s, const double *f, double since, double *mass, double *rates, double *by, double *tension)
{{
    double derivatives[DERIVATIVES];
    equations(s, f, &since, mass, rates, derivatives, tension);
    memset(by, 0, sizeof(double) * RATES * SIZE);
    for (int i = 0; i < DERIVATIVES; i++) by[place[i]] = derivatives[i];
}}

void xneck_observer_begin(xneck_observer *o, const double *pose)
{{
    memset(o, 0, sizeof *o);
    memcpy(o->s, start_state, sizeof o->s);
    for (int i = 0; i < SIZE; i++) o->P[i * SIZE + i] = start_sigma[i] * start_sigma[i];
    if (pose)
        for (int i = 0; i < N_; i++) o->pose[i] = pose[i];
    o->told = pose != NULL;
    use_all();
}}

static void begin_anew(xneck_observer *o)
{{
    double x0[M_], of_x0[M_ * M_];
    for (int j = 0; j < M_; j++) {{
        x0[j] = o->s[AT_X0 + j];
        for (int k = 0; k < M_; k++) of_x0[j * M_ + k] = o->P[(AT_X0 + j) * SIZE + AT_X0 + k];
    }}
    const double since = o->since;
    xneck_observer_begin(o, NULL);
    o->since = since;
    for (int j = 0; j < M_; j++) {{
        o->s[AT_X0 + j] = x0[j];
        for (int k = 0; k < M_; k++) o->P[(AT_X0 + j) * SIZE + AT_X0 + k] = of_x0[j * M_ + k];
    }}
}}

/* at rest where the cables pull the arm to */
static void started(xneck_observer *o, const double *theta)
{{
    double mass[N_ * N_], rates[RATES], by[RATES * SIZE], tension[M_], slope[N_ * N_], told[N_];
    const double still[M_] = {{0}};
    double *s = o->s;
    for (int j = 0; j < M_; j++) s[AT_THETA + j] = theta[j];
    for (int i = 0; i < N_; i++) told[i] = s[i] = o->told && isfinite(o->pose[i]) ? o->pose[i] : 0.0;
    for (int step = 0; step < NEWTON_STEPS; step++) {{
        double change[N_], most = 0.0;
        formed(s, still, 0.0, mass, rates, by, tension);
        for (int i = 0; i < N_; i++) {{
            change[i] = -rates[i];
            for (int k = 0; k < N_; k++) slope[i * N_ + k] = by[i * SIZE + k];
        }}
        if (!solved(slope, change, N_, 1))
            for (int i = 0; i < N_; i++) change[i] = 0.0;
        for (int i = 0; i < N_; i++) if (fabs(change[i]) > most) most = fabs(change[i]);
        const double share = most > MAX_NEWTON_RAD ? MAX_NEWTON_RAD / most : 1.0;
        for (int i = 0; i < N_; i++) s[i] += share * change[i];
        if (share * most < AT_REST_RAD) break;
    }}
    for (int i = 0; i < N_; i++)
        if (!(fabs(s[i]) < RANGE_RAD)) {{
            for (int k = 0; k < N_; k++) s[k] = told[k];
            break;
        }}
    double by_x0[N_ * M_];
    for (int i = 0; i < N_; i++) {{
        for (int k = 0; k < N_; k++) slope[i * N_ + k] = by[i * SIZE + k];
        for (int j = 0; j < M_; j++) by_x0[i * M_ + j] = -by[i * SIZE + AT_X0 + j];
    }}
    if (!solved(slope, by_x0, N_, M_)) return;
    double moved[N_ * M_];
    for (int i = 0; i < N_; i++)
        for (int j = 0; j < M_; j++) {{
            double x = 0.0;
            for (int k = 0; k < M_; k++) x += by_x0[i * M_ + k] * o->P[(AT_X0 + k) * SIZE + AT_X0 + j];
            moved[i * M_ + j] = o->P[i * SIZE + AT_X0 + j] = o->P[(AT_X0 + j) * SIZE + i] = x;
        }}
    for (int i = 0; i < N_; i++)
        for (int k = 0; k < N_; k++)
            for (int j = 0; j < M_; j++) o->P[i * SIZE + k] += moved[i * M_ + j] * by_x0[k * M_ + j];
}}

static void add_pose_noise(double *P, const double *s, const double *tension, double share)
{{
    double features[FEATURES], A[N_ * RANK], mean = 0.0;
    int next = N_ + 1;
    features[0] = 1.0;
    for (int i = 0; i < N_; i++) features[1 + i] = (s[i] - pose_middle[i]) / pose_half_range[i];
    for (int i = 0; i < N_; i++)
        for (int k = i; k < N_; k++) features[next++] = features[1 + i] * features[1 + k];
    for (int j = 0; j < M_; j++) mean += tension[j] / M_;
    features[next] = (mean - pose_tension[0]) / pose_tension[1];
    product(features, pose_factor, A, 1, FEATURES, N_ * RANK);
    for (int i = 0; i < N_; i++)
        for (int k = 0; k < N_; k++) {{
            double x = LAG_SIGMA_S * s[N_ + i] * LAG_SIGMA_S * s[N_ + k];
            for (int r = 0; r < RANK; r++) x += A[i * RANK + r] * A[k * RANK + r];
            if (i == k) x += pose_floor[i] * pose_floor[i];
            P[(AT_POSE + i) * SIZE + AT_POSE + k] += share * x;
        }}
}}

static void predicted_step(xneck_observer *o, double h, double since)
{{
    static const int joints = N_, motors = M_;
    double half[SIZE], middle[SIZE], mass[N_ * N_], rates[RATES], by[RATES * SIZE], tension[M_];
    double J[SIZE * SIZE], g[SIZE], V[SIZE * SIZE], V2[SIZE * SIZE], F[SIZE * SIZE], work[SIZE * SIZE];
    double *s = o->s;
    for (int i = 0; i < SIZE; i++) half[i] = o->speed_d[i] * (h / 2);
    for (int i = 0; i < joints; i++) half[i] = s[N_ + i] * (h / 2);
    for (int j = 0; j < motors; j++) half[AT_THETA + j] = s[AT_THETA + M_ + j] * (h / 2);
    for (int i = 0; i < SIZE; i++) middle[i] = s[i] + half[i];
    formed(middle, o->force, since, mass, rates, by, tension);
    double right[N_ * (SIZE + 1)];
    for (int i = 0; i < N_; i++) {{
        for (int k = 0; k < SIZE; k++) right[i * (SIZE + 1) + k] = by[i * SIZE + k];
        right[i * (SIZE + 1) + SIZE] = rates[i];
    }}
    solved(mass, right, N_, SIZE + 1);
    memset(J, 0, sizeof J);
    for (int i = 0; i < SIZE; i++) {{
        J[i * SIZE + i] = -decay[i];
        g[i] = -decay[i] * middle[i];
    }}
    for (int i = 0; i < N_; i++) {{
        J[i * SIZE + N_ + i] = 1.0;
        g[i] = middle[N_ + i];
        for (int k = 0; k < SIZE; k++) J[(N_ + i) * SIZE + k] = right[i * (SIZE + 1) + k];
        g[N_ + i] = right[i * (SIZE + 1) + SIZE];
    }}
    for (int j = 0; j < M_; j++) {{
        J[(AT_THETA + j) * SIZE + AT_THETA + M_ + j] = 1.0;
        g[AT_THETA + j] = middle[AT_THETA + M_ + j];
    }}
    /* speeds of the motors and memories of the cables follow each other, here as among the rates */
    for (int r = N_; r < RATES; r++) {{
        const int at = AT_THETA + M_ + r - N_;
        for (int k = 0; k < SIZE; k++) J[at * SIZE + k] = by[r * SIZE + k];
        g[at] = rates[r];
    }}
    for (int i = 0; i < SIZE; i++)
        for (int k = 0; k < SIZE; k++) g[i] -= J[i * SIZE + k] * half[k];
    memset(V, 0, sizeof V);
    for (int i = 0; i < SIZE; i++) V[i * SIZE + i] = 1.0;
    for (int i = 0; i < SIZE * SIZE; i++) work[i] = V[i] - GAMMA * h * J[i];
    solved(work, V, SIZE, SIZE);
    product(V, V, V2, SIZE, SIZE, SIZE);
    double change[SIZE], driven[SIZE];
    for (int i = 0; i < SIZE; i++) {{
        double x = 0.0;
        for (int k = 0; k < SIZE; k++) x += h * J[i * SIZE + k] * g[k];
        driven[i] = h * (g[i] - GAMMA * GAMMA * x);
    }}
    product(V2, driven, change, SIZE, SIZE, 1);
    for (int i = 0; i < SIZE * SIZE; i++) work[i] = (1 - 2 * GAMMA) * h * J[i];
    for (int i = 0; i < SIZE; i++) work[i * SIZE + i] += 1.0;
    product(V2, work, F, SIZE, SIZE, SIZE);
    product(F, o->P, work, SIZE, SIZE, SIZE);
    for (int i = 0; i < SIZE; i++)
        for (int k = 0; k < SIZE; k++) {{
            double x = 0.0;
            for (int l = 0; l < SIZE; l++)
                x += work[i * SIZE + l] * F[k * SIZE + l] + V[i * SIZE + l] * (noise[l] * h) * V[k * SIZE + l];
            o->P[i * SIZE + k] = x;
        }}
    add_pose_noise(o->P, middle, tension, 2 * h / POSE_TIME_S);
    made_symmetric(o->P);
    for (int i = 0; i < SIZE; i++) s[i] += change[i];
    for (int i = 0; i < N_; i++) o->speed_d[N_ + i] = change[N_ + i] / h;
    for (int j = 0; j < M_; j++) o->speed_d[AT_THETA + M_ + j] = change[AT_THETA + M_ + j] / h;
    for (int i = 0; i < M_ * S_; i++) {{
        double *z = &s[AT_THETA + 2 * M_ + i];
        *z = *z > memory_bound[i] ? memory_bound[i] : *z < -memory_bound[i] ? -memory_bound[i] : *z;
    }}
}}

static void measured_motors(xneck_observer *o, const double *theta)
{{
    double S[M_ * M_], K[M_ * SIZE], before[M_ * SIZE], e[M_];
    for (int j = 0; j < M_; j++) {{
        e[j] = theta[j] - o->s[AT_THETA + j];
        for (int k = 0; k < M_; k++) S[j * M_ + k] = o->P[(AT_THETA + j) * SIZE + AT_THETA + k];
        S[j * M_ + j] += theta_sigma[j] * theta_sigma[j];
        for (int i = 0; i < SIZE; i++) before[j * SIZE + i] = K[j * SIZE + i] = o->P[(AT_THETA + j) * SIZE + i];
    }}
    solved(S, K, M_, SIZE);
    for (int i = 0; i < SIZE; i++) {{
        for (int j = 0; j < M_; j++) o->s[i] += K[j * SIZE + i] * e[j];
        for (int k = 0; k < SIZE; k++)
            for (int j = 0; j < M_; j++) o->P[i * SIZE + k] -= K[j * SIZE + i] * before[j * SIZE + k];
    }}
    made_symmetric(o->P);
}}

void xneck_observer_step(xneck_observer *o, double interval, const double *theta, const double *f)
{{
    if (o->running && interval > MAX_GAP_S) {{
        o->since += interval;
        begin_anew(o);
    }} else if (o->running) {{
        int steps = (int)ceil(interval / MAX_STEP_S);
        if (steps < 1) steps = 1;
        for (int step = 0; step < steps; step++)
            predicted_step(o, interval / steps, o->since + (step + 0.5) * interval / steps);
        o->since += interval;
        measured_motors(o, theta);
    }}
    if (!o->running) started(o, theta);
    acts(o, f);
    o->running = 1;
}}

void xneck_observer_frame(xneck_observer *o, const double *angles, const double *sigma)
{{
    for (int i = 0; i < N_; i++) {{
        double by[SIZE];
        if (!isfinite(angles[i])) continue;
        for (int k = 0; k < SIZE; k++) by[k] = o->P[i * SIZE + k] + o->P[(AT_POSE + i) * SIZE + k];
        const double variance = by[i] + by[AT_POSE + i] + sigma[i] * sigma[i];
        const double e = angles[i] - o->s[i] - o->s[AT_POSE + i];
        for (int k = 0; k < SIZE; k++) {{
            o->s[k] += by[k] * (e / variance);
            for (int l = 0; l < SIZE; l++) o->P[k * SIZE + l] -= by[k] * (by[l] / variance);
        }}
        made_symmetric(o->P);
    }}
}}

void xneck_observer_read(const xneck_observer *o, double *alpha, double *alpha_d, double *covariance)
{{
    const double *P = o->P;
    for (int i = 0; i < N_; i++) {{
        alpha[i] = o->s[i] + o->s[AT_POSE + i];
        alpha_d[i] = o->s[N_ + i];
        for (int k = 0; k < N_; k++) {{
            const double b = P[(AT_POSE + i) * SIZE + AT_POSE + k];
            covariance[i * 2 * N_ + k] = P[i * SIZE + k] + b + P[i * SIZE + AT_POSE + k] + P[k * SIZE + AT_POSE + i];
            covariance[i * 2 * N_ + N_ + k] = P[i * SIZE + N_ + k] + P[(AT_POSE + i) * SIZE + N_ + k];
            covariance[(N_ + k) * 2 * N_ + i] = covariance[i * 2 * N_ + N_ + k];
            covariance[(N_ + i) * 2 * N_ + N_ + k] = P[(N_ + i) * SIZE + N_ + k] + POSE_RATE * POSE_RATE * b;
        }}
    }}
}}
"""


def c_source(observer: Observer) -> str:
    """The file's text. Raises Refused where a law cannot be written in C, with its name."""
    e, numbers, layout = observer.equations, observer.numbers, observer.numbers.layout
    n, m = layout.N, layout.M
    end_of_mass = n * n
    outputs = {"mass": e.mass, "rates": e.rates, "derivatives": e.derivatives, "tension": e.tension}
    inputs = {
        "state": [v.name for v in e.state],
        "force": [v.name for v in e.force],
        "since": [e.time.name],
    }
    assert len(e.mass) == end_of_mass
    acting, laws = _acting(observer)
    error = numbers.pose_error
    defines = {
        "N_": n,
        "M_": m,
        "S_": layout.S,
        "SIZE": layout.size,
        "RATES": len(e.rates),
        "DERIVATIVES": len(e.derivatives),
        "FEATURES": error.factor.shape[0],
        "RANK": error.factor.shape[2],
        "LAWS": laws,
        "AT_THETA": layout.theta.start,
        "AT_X0": layout.x0.start,
        "AT_POSE": layout.pose_error.start,
        "GAMMA": float(GAMMA),
        "LAG_SIGMA_S": LAG_SIGMA_S,
        "POSE_TIME_S": POSE_TIME_S,
        "POSE_RATE": 2 * np.pi * POSE_RATE_HZ,
        "MAX_STEP_S": MAX_STEP_S,
        "MAX_GAP_S": MAX_GAP_S,
        "NEWTON_STEPS": NEWTON_STEPS,
        "MAX_NEWTON_RAD": MAX_NEWTON_RAD,
        "AT_REST_RAD": AT_REST_RAD,
        "RANGE_RAD": RANGE_RAD,
    }
    constants = {
        "start_state": numbers.start,
        "start_sigma": numbers.start_sigma,
        "noise": numbers.noise,
        "decay": numbers.decay,
        "theta_sigma": numbers.theta_sigma,
        "memory_bound": np.minimum(np.append(numbers.memory_bound, 0.0), 1e300),
        "pose_middle": error.middle,
        "pose_half_range": error.half_range,
        "pose_tension": np.array(error.tension),
        "pose_floor": numbers.pose_floor,
        "pose_factor": error.factor.ravel(),
    }
    places = ", ".join(str(row * layout.size + column) for row, column in e.places)
    return _TEMPLATE.format(
        defines="\n".join(f"#define {name} {value!r}" for name, value in defines.items()),
        constants="\n".join(
            [f"static const double {name}[] = {{{_numbers(value)}}};" for name, value in constants.items()]
            + [f"static const int place[] = {{{places}}};"]
        ),
        functions=c_function("equations", inputs, outputs) + "\n" + acting,
    )


def _numbers(values: np.ndarray) -> str:
    return ", ".join(repr(float(v)) for v in values)


def _acting(observer: Observer) -> tuple[str, int]:
    """C of the force that acts in a row, by the laws of the actuators, and how many there are."""
    machine, m = observer.numbers.machine, observer.numbers.layout.M
    told = [variable(f"told{j}") for j in range(m)]
    laws = [law for law in machine.laws if type(law).acting_force is not Law.acting_force]
    texts: list[str] = []
    for name, is_first in (("first_acting", True), ("next_acting", False)):
        f = symbols(np.array(told, dtype=object))
        inputs: dict[str, list[str]] = {"f": [v.name for v in told]}
        before_names = [[f"b{k}_{j}" for j in range(m)] for k in range(len(laws))]
        inputs["before"] = [name for own in before_names for name in own]
        after: list[Expression] = []
        for law, names in zip(laws, before_names, strict=True):
            before = None if is_first else symbols(np.array([variable(v) for v in names], dtype=object))
            try:
                f = law.next_force(machine.values, f, before, observer.step_s)
            except Untraceable as error:
                raise Refused("observe", f"the law {law.name} cannot be written in C ({error})") from error
            after += list(elements_of(f).ravel())
        outputs: Mapping[str, list[Expression]] = {"acting": list(elements_of(f).ravel()), "after": after}
        texts.append(c_function(name, inputs, outputs))
    call = """\
static void acts(xneck_observer *o, const double *f)
{
    double after[LAWS * M_ + 1], acting[M_];
    if (o->running) next_acting(f, o->acting, acting, after);
    else first_acting(f, o->acting, acting, after);
    for (int j = 0; j < M_; j++) o->force[j] = acting[j];
    for (int k = 0; k < LAWS * M_; k++) o->acting[k] = after[k];
}
"""
    return "\n".join([*texts, call]), len(laws)
