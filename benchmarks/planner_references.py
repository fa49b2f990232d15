"""The same problem solved by IPOPT in the ways that users of CasADi know.

All are `IpoptSolver`: the same order of unknowns and constraints, the same options, the same start.
What differs is how values and derivatives are computed.
"""

from __future__ import annotations

import contextlib
import hashlib
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import casadi as ca

from planner_cases import OUT
from shoecal_core.compiler import find_compiler
from shoecal_core.files import atomic_write
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver, horizon_nlp, ipopt_options

LIBRARIES = OUT / "compiled"
FASTEST = ("-O3", "-march=native")
"""Slower to compile than -O1 by far, and a tenth faster then: the reference shall be fast."""
_SHARED = ("-fPIC", "-shared", "-w")
_JUDGE: dict[str, bool | int | float | str] = {
    "ipopt.tol": 1e-10,
    "ipopt.dual_inf_tol": 1e-8,
    "ipopt.compl_inf_tol": 1e-10,
    "ipopt.constr_viol_tol": 1e-10,
    "ipopt.bound_relax_factor": 0.0,
    "ipopt.max_iter": 1000,
}


def mx_ipopt(collocation: Collocation) -> IpoptSolver:
    """Matrix expressions (MX) that call the functions of one state: what CasADi's guide shows."""
    return IpoptSolver(collocation, _from_mx(collocation))


def judge(collocation: Collocation) -> IpoptSolver:
    """Tight tolerances and unrelaxed bounds, to tell what the optimum is."""
    options = ipopt_options(collocation.settings) | _JUDGE
    programme = horizon_nlp(collocation, ca.SX)
    return IpoptSolver(collocation, ca.nlpsol("judge", "ipopt", programme, options))


def compiled_ipopt(
    collocation: Collocation, folder: Path = LIBRARIES, optimisation: Sequence[str] = FASTEST
) -> IpoptSolver:
    """All functions of the MX problem (f, g, their first and second derivatives) as machine code.

    CasADi writes them out, the system's compiler translates them once; the library is kept. (Those
    of the SX problem are four times as much C and were slower when they were tried.)

    Args:
        collocation: the functions of one state.
        folder: for the libraries.
        optimisation: arguments of the compiler.
    """
    options = ipopt_options(collocation.settings)
    library = _library(_source(_from_mx(collocation)), folder, optimisation)
    return IpoptSolver(collocation, ca.nlpsol("compiled", "ipopt", str(library), options))


def _from_mx(collocation: Collocation) -> ca.Function:
    programme = horizon_nlp(collocation, ca.MX)
    return ca.nlpsol("horizon", "ipopt", programme, ipopt_options(collocation.settings))


def _source(solver: ca.Function) -> str:
    # CasADi writes into the current folder alone.
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        return Path(solver.generate_dependencies("programme.c")).read_text()


def _library(source: str, folder: Path, optimisation: Sequence[str]) -> Path:
    compiler, flags = find_compiler(), (*optimisation, *_SHARED)
    made_of = "\0".join((source, *compiler.command, compiler.version, *flags))
    library = folder / f"{hashlib.sha256(made_of.encode()).hexdigest()[:32]}.so"
    if library.is_file():
        return library
    print(f"compiling {len(source) / 1e6:.1f} MB of C, once: some minutes", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as scratch:
        written, made = Path(scratch) / "programme.c", Path(scratch) / "programme.so"
        written.write_text(source)
        subprocess.run([*compiler.command, *flags, str(written), "-o", str(made)], check=True)
        atomic_write(library, made.read_bytes())
    print(f"compiled in {time.perf_counter() - begin:.0f} s", flush=True)
    return library
