"""C source of a batch: each operation is done for as many samples as a processor's vector holds.

CasADi's own C handles one sample after another, and no compiler vectorises thousands of
statements in a row; GNU C's vector types (gcc and clang have them, for any processor) leave it no
choice. Sine and cosine are written out for vectors too: libm's take one number at a time, which
would be most of the time. The statements are divided into parts, because the time that a compiler
takes grows faster than a function's length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import casadi as ca

from shoecal_core.compiler import CompilerError

_PART = 1200
"""Instructions of a part: the planner's 16000 are compiled three times as fast as in one piece."""
_LARGEST = 8192
"""Vectors of registers and outputs: they lie on the stack, half a megabyte of it."""
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
    ca.OP_FABS: "(V)((I){0} & INT64_MAX)",
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
#include <stdint.h>

#if defined(__AVX512F__)
#define LANES 8
#define EACH(f) f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)
#elif defined(__AVX__)
#define LANES 4
#define EACH(f) f(0), f(1), f(2), f(3)
#else
#define LANES 2
#define EACH(f) f(0), f(1)
#endif
#define INPUTS {inputs}
#define OUTPUTS {outputs}

typedef double V __attribute__((vector_size(8 * LANES)));
typedef int64_t I __attribute__((vector_size(8 * LANES)));

static inline V choose(I which, V a, V b)
{{
  return (V)(((I)a & which) | ((I)b & ~which));
}}

static inline V truth(I which)
{{
  const V zero = {{0.0}};
  return (V)((I)(zero + 1.0) & which);
}}

/* Sine and cosine by their series about the nearest multiple of pi/2. The multiple of pi/2 is taken
   off in three parts, the first two of so few bits that their products with a whole number below
   2^20 are exact. Larger angles, and what is no number, clear the sign bits of `near`: their block
   is done again with libm's. */
static const double FARTHEST = 1e5;
static const double ROUNDS = 0x1.8p52;
static const double PART_1 = 0x1.921fb54400000p+0;
static const double PART_2 = 0x1.0b4611a600000p-34;
static const double PART_3 = 0x1.3198a2e037073p-69;

static inline void turn(V x, V *sine, V *cosine, I *near)
{{
  if (!near) {{
    for (int l = 0; l < LANES; ++l) {{
      (*sine)[l] = sin(x[l]);
      (*cosine)[l] = cos(x[l]);
    }}
    return;
  }}
  V zero = {{0.0}};
  *near &= ((I)x & INT64_MAX) - (I)(zero + FARTHEST);
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
}}

static inline V input(const double *const *rows, int i)
{{
#define SAMPLE(l) rows[l][i]
  return (V){{EACH(SAMPLE)}};
}}

{parts}

static void all_parts(const double *const *rows, V *w, V *y, I *near)
{{
{calls}
}}

void batch(const double *in, double *out, long count)
{{
  const V zero = {{0.0}};
  for (long first = 0; first < count; first += LANES) {{
    int used = count - first < LANES ? (int)(count - first) : LANES;
    const double *rows[LANES];
    V w[{registers}], y[OUTPUTS];
    for (int l = 0; l < LANES; ++l) rows[l] = in + INPUTS * (first + (l < used ? l : used - 1));
    for (int k = 0; k < OUTPUTS; ++k) y[k] = zero;
    I near = ~(I)zero;
    all_parts(rows, w, y, &near);
    int64_t signs = -1;
    for (int l = 0; l < LANES; ++l) signs &= near[l];
    if (signs >= 0) all_parts(rows, w, y, 0);
    for (int l = 0; l < used; ++l)
      for (int k = 0; k < OUTPUTS; ++k) out[OUTPUTS * (first + l) + k] = y[k][l];
  }}
}}
"""

_PART_FRAME = """\
static __attribute__((noinline))
void part_{number}(const double *const *rows, V *w, V *y, I *near)
{{
  const V zero = {{0.0}};
{lines}
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
    if function.sz_w() + function.size1_out(0) > _LARGEST:
        raise CompilerError(f"'{function.name()}' is too large for batches")
    instructions = range(function.n_instructions())
    parts = [
        _Part(function, instructions[begin : begin + _PART])
        for begin in range(0, len(instructions), _PART)
    ]
    return _FRAME.format(
        inputs=function.size1_in(0),
        outputs=function.size1_out(0),
        registers=max(1, function.sz_w()),
        per_quadrant=(2.0 / math.pi).hex(),
        sine=_series(3, 17),
        cosine=_series(2, 16),
        parts="\n".join(_definitions(parts)),
        calls="\n".join(f"  part_{number}(rows, w, y, near);" for number in range(len(parts))),
    )


def _definitions(parts: Sequence[_Part]) -> list[str]:
    """C functions of the parts, each storing only what a later one loads."""
    wanted: set[int] = set()
    texts = []
    for number, part in reversed(list(enumerate(parts))):
        stores = [f"w[{place}] = {name};" for place, name in part.made.items() if place in wanted]
        lines = "\n".join(f"  {line}" for line in (*part.lines, *stores))
        texts.append(_PART_FRAME.format(number=number, lines=lines))
        wanted = (wanted - set(part.made)) | part.loaded
    return texts


class _Part:
    """Some instructions in a row, in C.

    CasADi keeps what it computes in registers, which it uses again. A part holds values under
    names of its own; what is from before it loads from the registers.

    Attributes:
        lines: C statements.
        loaded: registers that are read before they are written.
        made: name of the last value of each register that is written.
    """

    def __init__(self, function: ca.Function, instructions: range) -> None:
        self.lines: list[str] = []
        self.loaded: set[int] = set()
        self.made: dict[int, str] = {}
        self._function = function
        self._rows = function.sparsity_out(0).row()
        self._turned: set[str] = set()
        for index in instructions:
            self._add(index)

    def _add(self, index: int) -> None:
        function, operation = self._function, self._function.instruction_id(index)
        takes, gives = function.instruction_input(index), function.instruction_output(index)
        name = f"v{index}"
        if operation == ca.OP_OUTPUT:
            value = self._value(takes[0])
            self.lines.append(f"y[{self._rows[gives[1]]}] = {value};")
            return
        if operation == ca.OP_INPUT:
            self.lines.append(f"V {name} = input(rows, {takes[1]});")
        elif operation == ca.OP_CONST:
            self.lines.append(f"V {name} = zero + {function.instruction_constant(index).hex()};")
        elif operation in {ca.OP_SIN, ca.OP_COS}:
            name = self._turn(self._value(takes[0]), sine=operation == ca.OP_SIN)
        else:
            operands = [self._value(place) for place in takes]
            self.lines.append(_statement(function.name(), operation, name, operands))
        self.made[gives[0]] = name

    def _value(self, place: int) -> str:
        """Name of what a register holds."""
        if place in self.made:
            return self.made[place]
        if place not in self.loaded:
            self.loaded.add(place)
            self.lines.append(f"V w{place} = w[{place}];")
        return f"w{place}"

    def _turn(self, angle: str, *, sine: bool) -> str:
        """Name of an angle's sine or cosine; the two are computed together."""
        both = f"s_{angle}", f"c_{angle}"
        if angle not in self._turned:
            self._turned.add(angle)
            self.lines.append(f"V {both[0]}, {both[1]};")
            self.lines.append(f"turn({angle}, &{both[0]}, &{both[1]}, near);")
        return both[0 if sine else 1]


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
