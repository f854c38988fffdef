#!/usr/bin/env python3
"""Compiles a unit for WebAssembly without instructions that load a number into all lanes (v128.load64_splat).

Clang 14 loses the order of these loads and of later stores: `x = pose * x` reads a coordinate of x that it has
replaced. The unit is compiled to LLVM's language. There each number that goes into a lane passes through an empty
assembly statement, so that it is loaded alone.
usage: no_load_splat.py COMPILER ARGUMENTS...   (CMAKE_CXX_COMPILER_LAUNCHER)
"""
import math
import os
import re
import subprocess
import sys

# %v = insertelement <2 x double> %w, double %x, i32 1: Clang loads any lane that way, and then replaces the others.
LANE = re.compile(r"^(\s*%\S+ = insertelement <\d+ x (.+?)> .+, \2 )"
                  r"(%[\w.$-]+|%\"[^\"]+\")(, i(?:32|64) .*)$")
# %v = bitcast double %x to <2 x i32>: a number that becomes lanes in another way.
CAST = re.compile(r"^(\s*%\S+ = bitcast (double|float|i64|i32) )(%[\w.$-]+|%\"[^\"]+\")( to <.*)$")
# %v = load <3 x double>, <3 x double>* %p, align 8: the lanes beyond whole registers are loaded as numbers.
PART = re.compile(r"^\s*(%\S+) = load (<(\d+) x (double|float|i64|i32|i16|i8)>), <.*>\* "
                  r"(%[\w.$-]+|%\"[^\"]+\"), align (\d+)")
BYTES = {"double": 8, "float": 4, "i64": 8, "i32": 4, "i16": 2, "i8": 1}
# Options of the second step, which generates code.
CODE = re.compile(r"-(O\w|m(?!llvm)\w+(=.*)?|fwasm-exceptions|ffp-contract=.*|sSUPPORT_LONGJMP=.*)$")


def by_number(text):
    """Loads vectors that fill no whole registers number by number."""
    count = 0
    for line in text:
        found = PART.match(line)
        if not found or int(found[3]) * BYTES[found[4]] % 16 == 0:
            yield line
            continue
        value, vector, lanes, kind, place, align = found.groups()
        made = "undef"
        for lane in range(int(lanes)):
            name = f"%no.load.part.{count}.{lane}"
            aligned = math.gcd(int(align), lane * BYTES[kind])
            to = value if lane + 1 == int(lanes) else name
            yield f"  {name}.at = getelementptr {vector}, {vector}* {place}, i32 0, i32 {lane}\n"
            yield f"  {name}.number = load {kind}, {kind}* {name}.at, align {aligned}\n"
            yield f"  {to} = insertelement {vector} {made}, {kind} {name}.number, i32 {lane}\n"
            made = to
        count += 1


def guarded(text):
    count = 0
    for line in by_number(text):
        found = LANE.match(line.rstrip("\n")) or CAST.match(line.rstrip("\n"))
        if not found:
            yield line
            continue
        before, kind, number, after = found.groups()
        through = f"%no.load.splat.{count}"
        count += 1
        wide = {"i1": "i32", "i8": "i32", "i16": "i32"}.get(kind)
        if wide:
            yield f"  {through}.wide = zext {kind} {number} to {wide}\n"
            yield f'  {through}.kept = call {wide} asm "", "=r,0"({wide} {through}.wide)\n'
            yield f"  {through} = trunc {wide} {through}.kept to {kind}\n"
        else:
            yield f'  {through} = call {kind} asm "", "=r,0"({kind} {number})\n'
        yield f"{before}{through}{after}\n"


def main(command):
    unit = command[command.index("-o") + 1] if "-o" in command else ""
    if "-c" not in command or not unit.endswith(".o"):
        return subprocess.call(command)
    middle = unit + ".ll"
    first = ["-S" if option == "-c" else option for option in command]
    first[first.index("-o") + 1] = middle
    status = subprocess.call(first + ["-emit-llvm"])
    if status:
        return status
    with open(middle, encoding="utf-8") as read, open(unit + ".kept.ll", "w", encoding="utf-8") as written:
        written.writelines(guarded(read))
    code = [a for a in command[1:] if CODE.match(a)]
    code += ["-Xclang", "-disable-llvm-passes", "-c", unit + ".kept.ll", "-o", unit]
    status = subprocess.call([command[0], *code])
    os.remove(middle), os.remove(unit + ".kept.ll")
    return status


sys.exit(main(sys.argv[1:]))
