"""C source of a batch: each operation is done for as many samples as a processor's vector holds.

CasADi's own C handles one sample after another, and no compiler vectorises thousands of
statements in a row; GNU C's vector types (gcc and clang have them, for any processor) leave it no
choice. Sine and cosine are written out for vectors too: libm's take one number at a time, which
would be most of the time.
"""

from __future__ import annotations

import math

import casadi as ca

from shoecal_core.compiler import CompilerError

_OPERATIONS = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_LT: "truth({0} < {1})",
    ca.OP_LE: "truth({0} <= {1})",
    ca.OP_EQ: "truth({0} == {1})",
    ca.OP_NE: "truth({0} != {1})",
    ca.OP_NOT: "truth({0} == 0.0)",
    ca.OP_AND: "truth(({0} != 0.0) & ({1} != 0.0))",
    ca.OP_OR: "truth(({0} != 0.0) | ({1} != 0.0))",
    ca.OP_IF_ELSE_ZERO: "choose({0} != 0.0, {1}, zero)",
    ca.OP_FABS: "choose({0} < 0.0, -{0}, {0})",
    # What is no number loses, as in libm.
    ca.OP_FMIN: "choose(({0} <= {1}) | ({1} != {1}), {0}, {1})",
    ca.OP_FMAX: "choose(({0} >= {1}) | ({1} != {1}), {0}, {1})",
}
_LIBM = {
    ca.OP_SQRT: "sqrt({0}[l])",
    ca.OP_ATAN: "atan({0}[l])",
    ca.OP_ATAN2: "atan2({0}[l], {1}[l])",
    ca.OP_ASIN: "asin({0}[l])",
    ca.OP_ACOS: "acos({0}[l])",
}
"""One sample after another."""

_FRAME = """\
#include <math.h>

#define LANES 8
#define INPUTS {inputs}
#define OUTPUTS {outputs}

typedef double V __attribute__((vector_size(64)));
typedef long long I __attribute__((vector_size(64)));

static inline V choose(I which, V a, V b)
{{
  return (V)(((I)a & which) | ((I)b & ~which));
}}

static inline V truth(I which)
{{
  const V one = {{1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0}};
  return (V)((I)one & which);
}}

/* Sine and cosine by their series about the nearest multiple of pi/2. The multiple of pi/2 is taken
   off in three parts, the first two of so few bits that their products with a whole number below
   2^20 are exact. Beyond that, and for what is no number, libm's own. */
#define FARTHEST 1e5
static const double ROUNDS = 0x1.8p52;
static const double PART_1 = 0x1.921fb54400000p+0;
static const double PART_2 = 0x1.0b4611a600000p-34;
static const double PART_3 = 0x1.3198a2e037073p-69;

static inline void turn(V x, V *sine, V *cosine)
{{
  V shifted = x * {per_quadrant} + ROUNDS;
  V whole = shifted - ROUNDS;
  V r = ((x - whole * PART_1) - whole * PART_2) - whole * PART_3;
  V z = r * r;
  V s = r + r * z * ({sine});
  V c = 1.0 + z * ({cosine});
  I quadrant = (I)shifted;
  I odd = -(quadrant & 1);
  *sine = (V)((I)choose(odd, c, s) ^ ((quadrant & 2) << 62));
  *cosine = (V)((I)choose(odd, s, c) ^ (((quadrant + 1) & 2) << 62));
  I near = (x >= -FARTHEST) & (x <= FARTHEST);
  for (int l = 0; l < LANES; ++l) {{
    if (!near[l]) {{
      (*sine)[l] = sin(x[l]);
      (*cosine)[l] = cos(x[l]);
    }}
  }}
}}

static inline V input(const double *const *rows, int i)
{{
  return (V){{rows[0][i], rows[1][i], rows[2][i], rows[3][i],
             rows[4][i], rows[5][i], rows[6][i], rows[7][i]}};
}}

void batch(const double *in, double *out, long count)
{{
  const V zero = {{0.0}};
  for (long first = 0; first < count; first += LANES) {{
    int used = count - first < LANES ? (int)(count - first) : LANES;
    const double *rows[LANES];
    V y[OUTPUTS];
    for (int l = 0; l < LANES; ++l) rows[l] = in + INPUTS * (first + (l < used ? l : used - 1));
    for (int k = 0; k < OUTPUTS; ++k) y[k] = zero;
{body}
    for (int l = 0; l < used; ++l)
      for (int k = 0; k < OUTPUTS; ++k) out[OUTPUTS * (first + l) + k] = y[k][l];
  }}
}}
"""


def batch_source(function: ca.Function) -> str:
    """C source of `void batch(const double *in, double *out, long count)`.

    Args:
        function: SX function of one dense vector (n,) with one output (m,).

    Raises:
        CompilerError: for other functions, and for operations that are not known here.
    """
    if not function.is_a("SXFunction") or (function.n_in(), function.n_out()) != (1, 1):
        raise CompilerError(f"'{function.name()}' is no SX function of one vector")
    rows = function.sparsity_out(0).row()
    held: dict[int, str] = {}  # names by the function's work registers, which it uses again
    turned: set[str] = set()
    lines: list[str] = []
    for index in range(function.n_instructions()):
        operation = function.instruction_id(index)
        takes, gives = function.instruction_input(index), function.instruction_output(index)
        name = f"v{index}"
        if operation == ca.OP_OUTPUT:
            lines.append(f"y[{rows[gives[1]]}] = {held[takes[0]]};")
            continue
        if operation == ca.OP_INPUT:
            lines.append(f"V {name} = input(rows, {takes[1]});")
        elif operation == ca.OP_CONST:
            lines.append(f"V {name} = zero + {function.instruction_constant(index).hex()};")
        elif operation in {ca.OP_SIN, ca.OP_COS}:
            angle = held[takes[0]]
            if angle not in turned:
                turned.add(angle)
                lines.append(f"V s_{angle}, c_{angle}; turn({angle}, &s_{angle}, &c_{angle});")
            name = f"{'s' if operation == ca.OP_SIN else 'c'}_{angle}"
        else:
            operands = [held[place] for place in takes]
            lines.append(_statement(function.name(), operation, name, operands))
        held[gives[0]] = name
    return _FRAME.format(
        inputs=function.size1_in(0),
        outputs=function.size1_out(0),
        per_quadrant=(2.0 / math.pi).hex(),
        sine=_series(3, 17),
        cosine=_series(2, 16),
        body="\n".join(f"    {line}" for line in lines),
    )


def _statement(function: str, operation: int, name: str, operands: list[str]) -> str:
    if operation in _OPERATIONS:
        return f"V {name} = {_OPERATIONS[operation].format(*operands)};"
    if operation in _LIBM:
        value = _LIBM[operation].format(*operands)
        return f"V {name}; for (int l = 0; l < LANES; ++l) {name}[l] = {value};"
    raise CompilerError(f"'{function}' has an operation that batches do not know ({operation})")


def _series(first: int, last: int) -> str:
    """Terms of the sine's (odd) or the cosine's (even) series as a polynomial in z, nested."""
    nested = ""
    for power in range(last, first - 1, -2):
        term = ((-1.0) ** (power // 2) / math.factorial(power)).hex()
        nested = f"{term} + z * ({nested})" if nested else term
    return nested
