"""Runs the command on this and other systems (Windows, under Wine). The result hashes must equal hashes/command.txt. The command
must write and read files whose names are in any language, and write equal bytes on every system.

command_hashes.py PROGRAM...         PROGRAM: the command, after its emulator if it has one
command_hashes.py --write PROGRAM... writes hashes/command.txt
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

KNOWN = pathlib.Path(__file__).resolve().parent / "hashes" / "command.txt"
INSTRUCTIONS = ("baseline", "avx2", "avx512")  # a processor takes its best instead of one that it lacks
NAME = "größe 漢"
CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = "0 1 3;0 3 2;4 6 7;4 7 5;0 4 5;0 5 1;2 3 7;2 7 6;0 2 6;0 6 4;1 5 7;1 7 3"


class Command:
    def __init__(self, program, folder):
        self.program, self.folder = [str(pathlib.Path(part).resolve()) for part in program], folder

    def run(self, *arguments, code=0, **environment):
        done = subprocess.run([*self.program, *arguments], cwd=self.folder, capture_output=True, check=False,
                              env={**os.environ, "ONCOLLIDE_DATA": "", **environment})
        if done.returncode != code:
            sys.exit(f"{' '.join(arguments)}: exit code {done.returncode}, not {code}\n{done.stderr.decode(errors='replace')}")
        return done

    def hash_of(self, arguments, **environment):
        lines = self.run("run", *arguments, **environment).stdout.decode().splitlines()
        return next(line.split()[1] for line in lines if line.startswith("hash "))


def expect(is_right, what):
    if not is_right:
        sys.exit(what)


def check_hashes(command):
    lines = [line.rsplit(" ", 1) for line in KNOWN.read_text().splitlines()]
    expect(len(lines) > 10, f"{KNOWN} is short")
    for text, known in lines:
        found = command.hash_of(text.split())
        expect(found == known, f"run {text}: hash {found}, not {known}")
    for instructions in INSTRUCTIONS:
        found = command.hash_of(lines[0][0].split(), ONCOLLIDE_ISA=instructions)
        expect(found == lines[0][1], f"ONCOLLIDE_ISA={instructions}: hash {found}, not {lines[0][1]}")
    expect(command.hash_of([*lines[0][0].split(), "--threads", "3"]) == lines[0][1], "three threads find something else")


def check_names(command):
    """Files whose names no code page of Windows has."""
    folder, mesh = command.folder, NAME + ".off"
    points = "\n".join("{} {} {}".format(*point) for point in CUBE)
    faces = "\n".join("3 " + face for face in FACES.split(";"))
    (folder / mesh).write_text(f"OFF\n8 12 0\n{points}\n{faces}\n", encoding="utf-8", newline="\n")
    output = command.run("check", mesh, mesh, "--pose-b", "0.5 0 0 0 0 0 1", code=1).stdout
    expect(b"colliding" in output, f"check says: {output}")
    missing = command.run("check", "漢 absent.off", mesh, code=66).stderr.decode()
    expect("漢 absent.off" in missing, f"the message does not name the file: {missing}")

    geometries = {"cube": {"mesh": {"file": mesh}}}
    bodies = [{"name": f"{NAME} {x}", "geometry": "cube", "position": [x, 0, 0]} for x in (0, 0.5, 3)]
    scene = {"schema": "oncollide.scene", "schema_version": 1, "geometries": geometries, "bodies": bodies}
    (folder / "scene.json").write_text(json.dumps(scene, ensure_ascii=False), encoding="utf-8")
    (folder / NAME).mkdir()
    copy = f"{NAME}/scene.json"
    command.run("scene", "scene.json", "--out", copy)
    written = json.loads((folder / copy).read_bytes())
    expect(written["geometries"]["cube"]["mesh"]["file"] == "../" + mesh, f"the copy names {written['geometries']}")
    expect(command.hash_of(["scene.json"]) == command.hash_of([copy]), "the copy has another hash")
    return copy


def check_bytes(command, scene):
    """A new file replaces an old file of its name, and has the bytes of standard output."""
    folder, table = command.folder, NAME + ".csv"
    for frames in ("3", "2"):
        command.run("run", scene, "--frames", frames, "--quiet", "--csv", table, "--json", NAME + ".json")
    text = (folder / table).read_bytes()
    expect(b"\r" not in text and text.count(b"\n") == 3, f"{table}: {text}")
    expect(NAME.encode() in text, f"{table} does not name the bodies: {text}")
    expect(b"\r" not in (folder / (NAME + ".json")).read_bytes(), "the JSON file has carriage returns")
    printed = command.run("run", scene, "--frames", "2", "--quiet", "--csv", "-").stdout
    expect(printed == text, f"standard output: {printed}\nthe file: {text}")
    rest = sorted(path.name for path in folder.iterdir() if path.name.endswith(".part"))
    expect(not rest, f"left behind: {rest}")


def seconds_of(process):
    """The processor time that a process has used."""
    times = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")


def check_interrupt(command):
    """Ctrl-C ends a run that would last for hours, and the results so far are written."""
    folder, table = command.folder, "long.csv"
    arguments = ["run", "many", "--bodies", "50", "--frames", "100000000", "--quiet", "--csv", table]
    running = subprocess.Popen([*command.program, *arguments], cwd=folder, stderr=subprocess.PIPE,
                               env={**os.environ, "ONCOLLIDE_DATA": ""})
    try:
        until = time.monotonic() + 120
        while seconds_of(running.pid) < 0.8:  # the start takes less
            expect(time.monotonic() < until and running.poll() is None, "the run does not start")
            time.sleep(0.1)
        running.send_signal(signal.SIGINT)
        errors = running.communicate(timeout=300)[1]
    finally:
        running.kill()
    expect(running.returncode == 130, f"exit code {running.returncode}, not 130, after Ctrl-C: {errors}")
    lines = (folder / table).read_text(encoding="utf-8").splitlines()
    expect(len(lines) > 2 and len({line.count(",") for line in lines}) == 1, f"{table} has {len(lines)} lines")


def main():
    arguments = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        if arguments[0] == "--write":
            command = Command(arguments[1:], folder)
            lines = [line.rsplit(" ", 1)[0] for line in KNOWN.read_text().splitlines()]
            KNOWN.write_text("".join(f"{line} {command.hash_of(line.split())}\n" for line in lines))
            return
        command = Command(arguments, pathlib.Path(folder))
        check_hashes(command)
        check_bytes(command, check_names(command))
        check_interrupt(command)
    print("as everywhere")


main()
