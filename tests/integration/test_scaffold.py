"""``skiros new``: what it writes works at once, and what it cannot write leaves everything as it was."""

from __future__ import annotations

import json
import os
import pty
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from support.installed_package import install

from skiros_py.cli.main import main
from skiros_py.plugins.loading import find_plugin
from skiros_py.scaffold.orders import NewPackage, NewSkill
from skiros_py.scaffold.package import draft_package
from skiros_py.scaffold.project import Knowledge, Project, knowledge_of
from skiros_py.scaffold.skill import draft_skill

ROOT = Path(__file__).parents[2]
Skiros = Callable[..., tuple[int, str, str]]

OPTION_SETS = """\
ontology scanning --class Scanner:sk:Device --class Reader:scanning:Scanner
    --relation scannedAt:sk:Manipulatable:sk:Station --relation storedIn:kitting:Part:kitting:Box
    --property scanned:sk:Manipulatable:boolean --property code:sk:Manipulatable:text
    --property weight:sk:Manipulatable:number
condition Scanned --role part:sk:Manipulatable --property scanning:scanned
condition Fresh --property scanned --value false --help-text 'Nobody scanned it yet'
condition HasCode --property code --abstract
condition Heavy --property weight --value 2.5
condition Coded --role thing:kitting:Starter --property code --value "A 'quoted' code"
condition ScannedAt --relation scannedAt
condition StoredIn --role it:kitting:Starter --role box:kitting:Box --relation scanning:storedIn
condition LiesIn --relation sk:in
condition StandsAt --relation sk:at
condition CloseBy --relation sk:near
primitive read_code --param camera:sk:Camera --param seconds:number
primitive wait_for_it
primitive beep --param 'times:integer=3 -- How often it beeps' --param 'text:text=a b' --param loud:boolean=true
    --param 'reader:scanning:Reader' --param robot:sk:Robot --param 'force:number [N]'
skill scan --help-text 'Scans a part.' --agent sk:Arm --param Part:sk:Manipulatable --param Station:sk:Station
    --pre 'RobotAtLocation(Robot, Station)' --post 'Scanned(Part)'
skill scan_fully --agent sk:Arm --param 'Part:sk:Manipulatable -- The part to scan' --param Station:sk:Station
    --param 'force:number=2 [N]' --param 'seconds:number=0.5 [s]' --pre 'RobotAtLocation(Robot, Station)'
    --pre 'not Scanned(Part)' --pre 'Fresh(Part)' --post 'ScannedAt(Part, Station)' --do read_code --do beep
    --target Station
skill unload --agent Base --param Kit:kitting:Kit --param Starter:kitting:Starter --param Box:kitting:Box
    --pre 'CanBeWorkedAt(Kit)' --pre 'RobotAtLocation(Robot, Kit)' --pre 'StoredIn(Starter, Box)'
    --post 'not StoredIn(Starter, Box)' --post 'Scanned(Starter)'
skill move_over --agent sk:Arm --param Gripper:sk:Gripper --param Part:sk:Manipulatable --param Old:kitting:Box
    --param New:kitting:Box --pre 'ObjectAtLocation(Part, Old)' --pre 'EmptyHanded(Gripper)'
    --pre 'Graspable(Part, Gripper)' --post 'ObjectAtLocation(Part, New)'
robot loader --start dock --limit max-linear=0.5 --limit max-gap=0.1
robot hauler
scene scan_cell --thing part:kitting:Starter --thing station:sk:Station --goal 'Scanned(part)'
scene hall --robot hauler --goal 'StandsAt(hauler, station)'
scene bare
"""
"""What is added to one package, one after the other."""


def words(line: str) -> list[str]:
    """Splits a command line as a shell does."""
    return shlex.split(line)


@pytest.fixture
def skiros(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Skiros:
    """Runs the command line; returns its exit status, stdout and stderr."""

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["skiros", *arguments])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        return int(ended.value.code or 0), out, err

    return run


@pytest.fixture(scope="module")
def pattern(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A package as it is when it is new."""
    order = NewPackage("my_scanning", skill="inspect", primitive="look_at", condition="Inspected")
    draft = draft_package(tmp_path_factory.mktemp("pattern"), order)
    draft.write()
    return draft.root


@pytest.fixture
def package(pattern: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, in which the command is called."""
    folder = tmp_path / "my_scanning"
    shutil.copytree(pattern, folder)
    monkeypatch.chdir(folder)
    return folder


def texts(folder: Path) -> dict[str, str]:
    files = (f for f in folder.rglob("*") if f.is_file() and "cache" not in str(f))
    return {str(f.relative_to(folder)): f.read_text(encoding="utf-8") for f in files}


def tool(folder: Path, *arguments: str, path: str = "") -> str:
    """Runs a program of the environment where nothing of the package is installed; returns what it says."""
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-m", *arguments], cwd=folder, env=environment, capture_output=True, text=True, timeout=250
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def ruff_options() -> list[str]:
    """The project's own rules, for a package that is not in its folder."""
    rules = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]["lint"]
    own = ("lint.pydocstyle.convention='google'", "lint.per-file-ignores={'tests/**'=['D','S']}")
    chosen = ["--select", ",".join(rules["select"]), "--ignore", ",".join(rules["ignore"])]
    return [*chosen, *(part for option in own for part in ("--config", option))]


# ---------------------------------------------------------------- what it writes works


def test_all_generated_files_pass_their_own_tests_the_linter_and_the_type_checker(
    package: Path, skiros: Skiros
) -> None:
    commands = re.split(r"\n(?=\S)", OPTION_SETS.strip())
    for line in commands:
        status, _, err = skiros("new", *words(line))
        assert status == 0, f"{line}: {err}"

    told = tool(package, "pytest", "-q", "-p", "no:dash", "-p", "no:cacheprovider", "-W", "error")
    tool(package, "ruff", "check", "--no-cache", *ruff_options(), ".")
    tool(package, "ruff", "format", "--no-cache", "--check", ".")
    tool(package, "mypy", "--cache-dir", str(package / ".cache"))

    tests = sum(text.count("\ndef test_") for text in texts(package).values())
    assert f"{tests} passed" in told
    assert tests > len(commands)


def test_the_skill_of_a_new_package_is_planned_and_executed_after_installation(
    package: Path, tmp_path: Path, skiros: Skiros
) -> None:
    site = tmp_path / "site"
    name = re.escape("my-scanning")
    part = "Part:sk:Manipulatable"
    skiros("new", "skill", "scan", "--agent", "sk:Arm", "--param", part, "--post", "Inspected(Part)", "--do", "look_at")
    install(package, site)

    done = tool(tmp_path, "skiros_py.cli", "run", "my_scanning", "--fake", path=f"{site}:{package / 'src'}")
    found = tool(tmp_path, "skiros_py.cli", "plugins", path=f"{site}:{package / 'src'}")

    assert "goal reached" in done
    assert re.search(rf"skills +scan +{name} 0\.1\.0 .* works", found)
    assert not re.search(rf"{name} 0\.1\.0 (?!.* works *$)", found, re.MULTILINE)


def test_the_test_of_a_skill_still_passes_beside_a_second_skill_with_the_same_effect(
    package: Path, skiros: Skiros
) -> None:
    for name in ("scan", "read"):
        options = ("--agent", "sk:Arm", "--param", "Part:sk:Manipulatable", "--post", "Inspected(Part)")
        assert skiros("new", "skill", name, *options)[0] == 0

    told = tool(package, "pytest", "-q", "-p", "no:dash", "-p", "no:cacheprovider", "-W", "error", "tests/skills")

    assert "failed" not in told


def test_the_names_in_a_generated_package_carry_its_own_so_that_no_two_packages_clash(
    package: Path, tmp_path: Path
) -> None:
    with Project.around(package).as_installed():
        draft = draft_package(tmp_path, NewPackage("my_sorting"))
        draft.write()
        again = draft_package(tmp_path, NewPackage("my_storing", skill="store")).new

    assert "src/my_sorting/skills/my_sorting_inspect.py" in draft.new
    assert "src/my_sorting/primitives/my_sorting_look_at.py" in draft.new
    assert '"MySortingInspected"' in draft.new["src/my_sorting/conditions/my_sorting_inspected.py"]
    assert "src/my_storing/skills/store.py" in again
    assert "src/my_storing/primitives/my_storing_look_at.py" in again
    assert "passed" in tool(draft.root, "pytest", "-q", "-p", "no:dash", "-p", "no:cacheprovider", "-W", "error")


def test_check_plugin_names_what_in_a_new_package_does_nothing_yet(package: Path, skiros: Skiros) -> None:
    status, said, _ = skiros("check-plugin", f"{package}/", "--no-run")

    warnings = [line for line in said.splitlines() if "placeholder" in line]
    assert status == 0
    assert [line.partition(": ")[0] for line in warnings] == ["warning"] * len(warnings)
    assert any("primitives/look_at.py" in line and "LookAt does nothing yet" in line for line in warnings)


def test_a_package_can_be_named_src(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # ``python -m pytest`` puts the checkout on the path, where ``src`` is a folder.
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place and Path(place) != ROOT])
    draft = draft_package(tmp_path, NewPackage("src"))
    draft.write()

    assert "passed" in tool(draft.root, "pytest", "-q", "-p", "no:dash", "-p", "no:cacheprovider", "-W", "error")


def test_a_generated_robot_equals_the_shipped_one_except_for_names(package: Path, skiros: Skiros) -> None:
    assert skiros("new", "robot", "panda")[0] == 0

    def facts(text: str) -> list[str]:
        return [
            line for line in text.splitlines() if "sk:" in line and "<http" not in line and not line.startswith("#")
        ]

    robot = find_plugin("skiros.robots", "mobile_panda").individuals
    parts = robot.with_name("mobile_panda_devices.ttl")
    shipped = "\n".join(file.read_text(encoding="utf-8") for file in (robot, parts))
    own = (package / "src" / "my_scanning" / "robots" / "panda.ttl").read_text(encoding="utf-8")
    renamed = re.sub(r"scene:panda_(\w+)", r"scene:\1_1", own).replace("scene:panda ", "scene:robot_1 ")
    assert facts(renamed) == facts(shipped)


# ---------------------------------------------------------------- what it says


def test_a_dry_run_shows_the_files_that_are_then_written_and_writes_none(package: Path, skiros: Skiros) -> None:
    before = texts(package)
    command = ("new", "primitive", "read_code", "--param", "camera:sk:Camera", "--json")

    planned = json.loads(skiros(*command, "--dry-run")[1])
    assert texts(package) == before
    written = json.loads(skiros(*command)[1])

    after = texts(package)
    assert planned == {**written, "written": False}
    assert sorted(written["new"]) == sorted(after.keys() - before.keys())
    assert written["changed"] == [name for name in before if before[name] != after[name]]


def test_a_dry_run_of_a_package_writes_nothing(tmp_path: Path, skiros: Skiros) -> None:
    status, out, _ = skiros("new", "package", "my_boxes", "--dir", str(tmp_path), "--dry-run")

    assert status == 0
    assert "inspect.py" in out
    assert list(tmp_path.iterdir()) == []


def test_the_new_files_and_the_next_commands_are_printed(package: Path, skiros: Skiros) -> None:
    status, out, _ = skiros("new", "primitive", "read_code")

    assert status == 0
    assert "read_code.py" in out
    assert "pyproject.toml (changed)" in out
    assert out.splitlines()[-2:] == ["    pytest tests/primitives/test_read_code.py", "    pip install -e ."]


def test_without_a_next_command_none_is_printed(package: Path, skiros: Skiros) -> None:
    _, out, _ = skiros("new", "ontology", "scanning", "--class", "Scanner:sk:Device")

    assert "scanning.ttl" in out
    assert "next:" not in out


def test_on_a_terminal_missing_arguments_are_prompted_for(package: Path) -> None:
    said = ["sk:Arm", "Part:sk:Manipulatable", "", "", "Inspected(Part)", "", "look_at", ""]
    ours, theirs = pty.openpty()
    with os.fdopen(ours, "wb", buffering=0) as keyboard:
        process = subprocess.Popen(
            [sys.executable, "-m", "skiros_py.cli", "new", "skill", "scan"],
            cwd=package, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        keyboard.write("".join(f"{line}\n" for line in said).encode())
        _, err = process.communicate(timeout=60)
        os.close(theirs)

    assert process.returncode == 0, err
    assert "What holds after it" in err
    text = (package / "src" / "my_scanning" / "skills" / "scan.py").read_text(encoding="utf-8")
    assert 'post = (INSPECTED("part"),)' in text
    assert 'Do.of("look_at", camera=P("camera"))' in text


# ---------------------------------------------------------------- what it refuses

BAD = {
    "skill Scan-Part": "such as 'scan_part'",
    "skill class": "a word of Python",
    "skill inspect": "there is a skill 'inspect' of my-scanning already",
    "skill look_at": "there is a primitive 'look_at' of my-scanning already",
    "skill pick": "there is a skill 'pick' of skiros-skills already",
    "skill scan": "give --agent CLASS",
    "skill scan --agent sk:Arm": "give a --post",
    "skill scan --agent sk:Gripper --post 'Inspected(Gripper)'": "has no skill manager",
    "skill scan --agent sk:Arn --post 'Inspected(Part)'": "Did you mean 'sk:Arm'?",
    "skill scan --agent sk:Arm --post 'Inspcted(Arm)'": "Did you mean 'Inspected'?",
    "skill scan --agent sk:Arm --post 'Inspected(Part)'": "unknown parameter 'part' in Inspected(part)",
    "skill scan --agent sk:Arm --post 'Inspected(Arm, Arm)'": "takes (part), got (Arm, Arm)",
    "skill scan --agent sk:Arm --post 'Inspected(Arm)'": "it must be a sk:Manipulatable there",
    "skill scan --agent sk:Arm --post 'Inspected'": "write a word and parameters",
    "skill scan --agent sk:Arm --param Part:sk:Manipulatable --post 'Inspected(Part)' --do fly": "unknown primitive",
    "skill scan --agent sk:Arm --param Part:sk:Manipulatable --post 'Inspected(Part)' --target X": "as --target of",
    "skill scan --agent sk:Arm --param A:sk:Manipulatable --param A:sk:Arm --post 'Inspected(A)'": "two parameters 'a'",
    "skill go --agent sk:Arm --param A:sk:Robot --param B:sk:Station --post 'not RobotAtLocation(A, B)'": "is not so",
    "skill kind --agent sk:Arm --param P:sk:Manipulatable --post 'Inspected(P)'": "two things called Kind",
    "skill scan --agent sk:Arm --param target:sk:Manipulatable --post 'Inspected(target)'": "something called 'target'",
    "skill scan --agent sk:Arm --param In:sk:Manipulatable --post 'Inspected(In)'": "a word of Python",
    "skill scan --agent sk:Arm --param Part:kitting:Part --param Box:kitting:Box --param Kit:kitting:Kit"
    " --post 'InKit(Part, Kit)'": "cannot be brought about",
    "primitive read --param camera": "write KEY:TYPE",
    "primitive read --param camera:sk:Camra": "Did you mean 'sk:Camera'?",
    "primitive read --param s:nummer": "Did you mean 'number'?",
    "primitive read --param s:number=nan": "'nan' is no number",
    "primitive read --param s:integer=1.5": "'1.5' is no integer",
    "primitive read --param 's:text [m]'": "a text has no unit",
    "primitive read --param 'c:sk:Camera=camera_1'": "neither default nor unit",
    "primitive read --param Camera:sk:Camera": "such as 'camera'",
    "primitive read --param world:text": "could not be given in a test",
    "primitive read --help-text ' '": "one sentence",
    "primitive success": "two things called Success",
    "condition Scanned": "either --property or --relation",
    "condition Scanned --property my_scanning:inspectd": "Did you mean 'my_scanning:inspected'?",
    "condition Scanned --property my_scanning:inspected --relation sk:at": "either --property or --relation",
    "condition Scanned --role part:sk:Station --property my_scanning:inspected": "part is a sk:Station",
    "condition Scanned --role a:sk:Robot --relation sk:at": "takes two roles",
    "condition Scanned --role a:number --property my_scanning:inspected": "must be of a class",
    "condition Scanned --property my_scanning:inspected --value perhaps": "needs true or false, got 'perhaps'",
    "condition Scanned --property sk:pose --value 1": "are not compared",
    "condition scanned --property my_scanning:inspected": "such as 'Scanned'",
    "condition Inspected --property my_scanning:inspected": "there is a condition 'Inspected' of my-scanning already",
    "condition Scene --property my_scanning:inspected": "two things called SCENE",
    "ontology scanning": "it has no word yet",
    "ontology my_scanning --class A:sk:Object": "stands for",
    "ontology sk --class A:sk:Object": "stands for",
    "ontology scanning --class A": "write NAME:PARENT",
    "ontology scanning --class A:sk:Objekt": "Did you mean 'sk:Object'?",
    "ontology scanning --class A:scanning:A": "scanning",
    "ontology scanning --property p:sk:Object:colour": "unknown type 'colour'",
    "ontology scanning --property p:sk:Object:text --property p:sk:Robot:text": "'p' is declared twice",
    "robot loader --limit max-speed=1": "unknown limit",
    "robot loader --limit max-linear=fast": "a number above 0",
    "robot mobile_panda": "there is a robot 'mobile_panda' already",
    "scene kitting": "there is a scene 'kitting' already",
    "scene my_scanning": "there is a scene 'my_scanning' already",
    "scene cell --robot rover": "unknown robot 'rover'",
    "scene cell --thing part:number": "must be of a class",
    "scene cell --thing part:sk:Manipulatable --goal 'Inspected(part, part)'": "takes (part)",
    "scene cell --goal 'Inspected(part)'": "Inspected needs one element of the scene: none",
}
"""What the message says, by what is asked for."""


@pytest.mark.parametrize("line", BAD)
def test_invalid_arguments_are_reported_and_nothing_is_written(line: str, package: Path, skiros: Skiros) -> None:
    before = texts(package)

    status, out, err = skiros("new", *words(line))

    assert (status, out) == (2, "")
    assert BAD[line] in err
    assert texts(package) == before


BAD_PACKAGES = {
    "My-Scanning": "such as 'my_scanning'",
    "import": "a word of Python",
    "numpy": "Python finds a module of that name already",
    "json": "Python finds a module of that name already",
    "taken": "is there already",
    "ok --skill pick": "there is a skill 'pick' of skiros-skills already; choose another name by --skill",
    "ok --condition Holding": "choose another name by --condition",
    "tests": "every package has tests of that name",
    "conftest": "every package has tests of that name",
    "ok --help-text 'two\nlines'": "one line",
}


@pytest.mark.parametrize("line", BAD_PACKAGES)
def test_an_invalid_package_is_refused(line: str, tmp_path: Path, skiros: Skiros) -> None:
    (tmp_path / "taken").mkdir()

    status, _, err = skiros("new", "package", *words(line), "--dir", str(tmp_path))

    assert status == 2
    assert BAD_PACKAGES[line] in err
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
    assert list((tmp_path / "taken").iterdir()) == []


@pytest.mark.parametrize("kind", ["skill", "primitive", "condition", "ontology", "robot", "scene"])
def test_adding_to_a_folder_outside_a_package_is_refused(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, skiros: Skiros
) -> None:
    monkeypatch.chdir(tmp_path)

    status, out, _ = skiros("new", kind, "thing", "--json")

    assert status == 2
    assert "is in no package" in json.loads(out)["error"]


def test_an_existing_file_is_never_overwritten(package: Path, skiros: Skiros) -> None:
    own = package / "tests" / "primitives" / "test_read_code.py"
    own.write_text("mine", encoding="utf-8")
    before = texts(package)

    for option in ((), ("--dry-run",)):
        status, _, err = skiros("new", "primitive", "read_code", *option)
        assert status == 2
        assert "tests/primitives/test_read_code.py: there already" in err
    assert texts(package) == before


def test_a_condition_of_the_package_that_does_not_load_is_named_with_its_reason(package: Path, skiros: Skiros) -> None:
    (package / "src" / "my_scanning" / "conditions" / "inspected.py").write_text("1 / 0", encoding="utf-8")

    status, _, err = skiros("new", "skill", "scan", "--agent", "sk:Arm", "--post", "Inspected(Arm)")

    assert status == 2
    assert "unknown condition 'Inspected'" in err
    assert "ZeroDivisionError" in err


def test_preconditions_that_a_generated_scene_cannot_fulfil_are_reported_with_the_reason(
    package: Path, skiros: Skiros
) -> None:
    params = ("--param", "Part:sk:Manipulatable", "--param", "Slot:kitting:Compartment")
    wanted = ("--pre", "FitsIn(Part, Slot)", "--post", "Inspected(Part)")

    status, out, _ = skiros("new", "skill", "squeeze", "--agent", "sk:Arm", *params, *wanted, "--json")

    assert status == 0
    (scene,) = json.loads(out)["notes"]
    assert "scenes/squeeze.ttl does not make it true: FitsIn(part, slot) (the size of part_1 is not known)" in scene


def test_without_installed_skills_a_new_skill_names_no_robot(package: Path) -> None:
    with knowledge_of(Project.around(package)) as known:
        own = {name: type_ for name, type_ in known.catalogue.conditions.items() if name == "Inspected"}
        alone = Knowledge(known.project, known.ontology, replace(known.catalogue, conditions=own))
        draft = draft_skill(
            alone, NewSkill("scan", agent="sk:Arm", params=("Part:sk:Manipulatable",), post=("Inspected(Part)",))
        )

    text = draft.new["src/my_scanning/skills/scan.py"]
    assert "robot" not in text
    assert 'part: str = param("sk:Manipulatable", "The part.")' in text
