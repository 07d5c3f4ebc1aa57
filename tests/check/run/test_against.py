"""`meshgauge check --against`: baselines of a git revision."""

import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import unittest

from harness import BINARY, ENVIRONMENT, until
from workplace import Workplace, square

IDENTITY = {"GIT_AUTHOR_NAME": "Test", "GIT_AUTHOR_EMAIL": "test@example.com", "GIT_COMMITTER_NAME": "Test",
            "GIT_COMMITTER_EMAIL": "test@example.com", "GIT_CONFIG_NOSYSTEM": "1", "GIT_CONFIG_GLOBAL": os.devnull}


def pointer_of(data):
    digest = hashlib.sha256(data).hexdigest()
    return digest, f"version https://git-lfs.github.com/spec/v1\noid sha256:{digest}\nsize {len(data)}\n"


def scene(buffer, size):
    """A glTF of a triangle whose buffer is beside it, of this many metres; and that buffer."""
    data = struct.pack("<9f", 0, 0, 0, size, 0, 0, 0, size, 0)
    document = {"asset": {"version": "2.0"}, "buffers": [{"uri": buffer, "byteLength": len(data)}],
                "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                               "max": [size, size, 0]}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
                "scenes": [{"nodes": [0]}], "scene": 0}
    return json.dumps(document), data


@unittest.skipUnless(shutil.which("git"), "needs git")
class Against(Workplace):
    def setUp(self):
        super().setUp()
        self.git("init", "--quiet", "--initial-branch=main")

    def git(self, *arguments, folder="."):
        done = subprocess.run(["git", "-c", "protocol.file.allow=always", *arguments], cwd=self.folder / folder, text=True,
                              capture_output=True, env={**os.environ, **IDENTITY}, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.strip()

    def commit(self, folder="."):
        self.git("add", "--all", folder=folder)
        self.git("commit", "--quiet", "--message=change", folder=folder)
        return self.git("rev-parse", "HEAD", folder=folder)

    def verdicts(self, code, *arguments):
        report = self.report(code, *arguments)
        return {gate["name"]: gate["verdict"] for gate in report["gates"]}

    def error_of(self, *arguments):
        gates = self.report(3, *arguments)["gates"]
        return next(gate["error"]["message"] for gate in gates if gate["error"])

    def test_baselines_are_those_of_the_revision_and_reports_name_it(self):
        self.file("baselines/part.obj", square())
        self.file("parts/part.obj", square())
        commit = self.commit()
        self.file("baselines/part.obj", square(5.0))  # here, the baseline was moved with the part
        self.file("parts/part.obj", square(5.0))
        self.commit()
        self.manifest([("part", "parts/part.obj", "baselines/part.obj", "1 mm")])
        self.exits(0, "gates.yaml")
        kinds = ("json", "html", "junit", "markdown", "sarif", "code-quality")
        result = self.exits(1, "gates.yaml", "--against", "main~1", *(f"--{kind}=out.{kind}" for kind in kinds))
        self.assertIn(f"1 gate: 1 fail; against main~1 ({commit[:12]})", result.stdout)
        report = json.loads((self.folder / "out.json").read_text())
        self.assertEqual(report["against"], {"ref": "main~1", "commit": commit})
        self.assertEqual(report["gates"][0]["baseline"], "main~1:baselines/part.obj")
        self.assertGreater(report["gates"][0]["distance"]["lower"], 4.9)
        for kind in ("html", "markdown", "sarif"):
            text = (self.folder / f"out.{kind}").read_text()
            self.assertIn(commit[:12], text, kind)
            self.assertIn("main~1", text, kind)
        self.assertIn("main~1:baselines/part.obj", (self.folder / "out.junit").read_text())
        self.assertNotIn("against", self.report(0, "gates.yaml"))
        sub = self.folder / "sub"
        sub.mkdir()
        process = subprocess.run([BINARY, "check", "../gates.yaml", "--against", commit[:10]], cwd=sub, env=ENVIRONMENT,
                                 capture_output=True, text=True, check=False)
        self.assertEqual(process.returncode, 1, process.stderr)

    def test_a_part_is_compared_with_itself(self):
        self.file("part.obj", square())
        self.commit()
        self.file("part.obj", square(2.0))
        self.exits(1, "part.obj", "--against", "HEAD", "--max-distance", "1")
        self.exits(0, "part.obj", "--against", "HEAD", "--max-distance", "3")
        self.exits(1, "part.obj", "part.obj", "--against", "HEAD", "--max-distance", "1")
        self.file("gates.yaml", "version: 1\ngates:\n  - {name: '{stem}', candidate: 'p*.obj', baseline: '{name}', max_distance: 1}\n")
        self.assertEqual(self.verdicts(1, "gates.yaml", "--against", "HEAD"), {"part": "fail"})
        self.assertIn("is the candidate itself", self.exits(3, "gates.yaml").stderr)

    def test_pictures_and_maps_show_the_revision(self):
        self.file("part.obj", square())
        self.commit()
        self.file("part.obj", square(2.0))
        self.exits(1, "part.obj", "--against", "HEAD", "--max-distance", "1", "--html=r.html", "--pictures=p", "--deviation=m.ply")
        self.assertIn("data:image/png", (self.folder / "r.html").read_text())
        self.assertEqual([path.suffix for path in (self.folder / "p").iterdir()], [".png"])
        self.assertTrue((self.folder / "m.ply").exists())

    def test_forty_parts_with_pointers_renames_and_a_submodule(self):
        pointed = square()
        digest, pointer = pointer_of(pointed)
        names = [f"part{i:02}" for i in range(36)]
        for name in names:
            self.file(f"base/{name}.obj", square())
        self.file("base/pointed.obj", pointer)
        self.file("base/unfetched.obj", pointer_of(b"nowhere")[1])
        self.file("base/old.obj", square())
        self.file("library/x.obj", square())
        os.symlink("part00.obj", self.folder / "base/link.obj")
        other = self.folder / "other"
        other.mkdir()
        self.git("init", "--quiet", "--initial-branch=main", folder="other")
        (other / "inner.obj").write_bytes(square())
        self.commit(folder="other")
        self.git("submodule", "--quiet", "add", "./other", "module")
        self.commit()
        store = self.folder / ".git/lfs/objects" / digest[:2] / digest[2:4]
        store.mkdir(parents=True)
        (store / digest).write_bytes(pointed)
        self.git("mv", "base/old.obj", "base/new.obj")
        self.git("mv", "library/x.obj", "base/x.obj")
        for name in names:
            self.file(f"base/{name}.obj", square(0.5))
        self.commit()
        gates = [(name, f"base/{name}.obj", f"base/{name}.obj", "1 mm") for name in names]
        gates += [(name, "flat.obj", path, "1 mm") for name, path in (
            ("pointed", "base/pointed.obj"), ("unfetched", "base/unfetched.obj"), ("renamed", "base/new.obj"),
            ("moved", "base/x.obj"), ("module", "module/inner.obj"), ("link", "base/link.obj"), ("outside", "/dev/null"))]
        self.manifest(gates)
        report = self.report(3, "gates.yaml", "--against", "HEAD~1")
        found = {gate["name"]: gate for gate in report["gates"]}
        passed = {name for name, gate in found.items() if gate["verdict"] == "pass"}
        self.assertEqual(passed, {*names, "pointed"})
        for name, words in {"unfetched": "is a Git LFS pointer in HEAD~1", "renamed": "is not in HEAD~1 (",
                            "moved": ": there it is 'library/x.obj'", "module": "lies in the submodule 'module'",
                            "link": "is a symbolic link in HEAD~1", "outside": "is outside of the repository"}.items():
            self.assertIn(words, found[name]["error"]["message"])
            self.assertIsNotNone(found[name]["manifest"]["line"])
        self.assertNotIn("meshgauge-against", json.dumps(report))  # copies lie there

    def test_a_file_of_the_revision_that_no_candidate_has_is_an_error(self):
        for name in ("kept", "deleted", "moved", "Case", "other"):
            self.file(f"parts/{name}.obj", square())
        self.file("sub/parts/deep/deleted.obj", square())
        self.file("elsewhere/x.obj", square())
        self.commit()
        for name in ("parts/deleted", "sub/parts/deep/deleted", "elsewhere/x"):
            self.git("rm", "--quiet", f"{name}.obj")
        self.git("mv", "parts/moved.obj", "attic.obj")
        self.git("mv", "parts/Case.obj", "parts/case.obj")
        (self.folder / "parts/other.obj").unlink()  # also where it is not committed
        self.file("sub/parts/deep/left.obj", square())
        self.commit()
        gates = ("gates:\n  - {name: '{stem}', candidate: 'parts/*.obj', baseline: 'parts/{name}', max_distance: 1%s}\n"
                 "  - {name: 'sub {stem}', candidate: 'sub/**/*.obj', baseline: 'sub/{dir}/{name}', max_distance: 1%s}\n")
        self.file("gates.yaml", "version: 1\n" + gates % ("", ""))
        report = self.report(3, "gates.yaml", "--against", "HEAD~1")
        found = {gate["name"]: gate for gate in report["gates"]}
        lost = {f"HEAD~1:{name}.obj" for name in ("parts/deleted", "parts/moved", "parts/Case", "parts/other", "sub/parts/deep/deleted")}
        self.assertEqual(set(found), {"kept", "case", "sub left", *lost})
        self.assertEqual(found["kept"]["verdict"], "pass")
        self.assertIn("there it is 'parts/Case.obj'", found["case"]["error"]["message"])
        for name in lost:
            self.assertEqual(found[name]["verdict"], "error")
            line = 4 if "sub" in name else 3
            glob = "sub/**/*.obj" if "sub" in name else "parts/*.obj"
            self.assertEqual(found[name]["manifest"]["line"], line)
            self.assertIn(f"the baseline '{name}' has no candidate: '{glob}' finds none; if it is gone on purpose", found[name]["error"]["message"])
            self.assertEqual((found[name]["candidate"], found[name]["baseline"]), ("", name))
        reports = ("html", "junit", "markdown", "sarif", "code-quality")
        self.exits(3, "gates.yaml", "--against", "HEAD~1", *(f"--{kind}=out.{kind}" for kind in reports))
        for kind in reports:
            text = (self.folder / f"out.{kind}").read_text()
            self.assertIn("HEAD~1:parts/deleted.obj", text, kind)
            self.assertNotIn("unnamed", text, kind)
        self.exits(0, "gates.yaml", "--against", "HEAD~1", "--only", "kept")
        ignored = ", unmatched_baselines: ignore"
        self.file("gates.yaml", "version: 1\n" + gates % (ignored, ignored))
        self.assertEqual(set(self.verdicts(3, "gates.yaml", "--against", "HEAD~1")), {"kept", "case", "sub left"})

    def lost(self, candidate, baseline, manifest="gates.yaml", more=""):
        """The paths of the revision HEAD~1 that have no candidate."""
        self.file(manifest, "version: 1\ngates:\n  - {name: '{dir} {name}', candidate: '%s', baseline: '%s', max_distance: 1%s}\n"
                  % (candidate, baseline, more))
        gates = self.report(3, manifest, "--against", "HEAD~1")["gates"]
        return {gate["baseline"].removeprefix("HEAD~1:") for gate in gates if not gate["candidate"]}

    def test_losses_in_strange_places(self):
        places = ("app/[id]/parts", "assets/a/golden", "assets/b/c/golden", "Base", "links")
        for place in places:
            for name in ("left", "lost"):
                self.file(f"{place}/{name}.obj", square())
        self.file("Base/lost one .obj", square())
        self.file("Base/.hidden.obj", square())
        self.file("base/left.obj", square())
        self.file("names/left.obj", square())
        self.file("names/a\x01.obj", square())
        self.file("flatter/a/b.obj", square())
        self.file("flatter/c/d.obj", square())
        (self.folder / "links/link.obj").symlink_to("left.obj")
        self.commit()
        for place in places:
            self.git("rm", "--quiet", f"{place}/lost.obj")
        for path in ("links/link.obj", "names/a\x01.obj", "Base/lost one .obj"):
            self.git("rm", "--quiet", path)
        for at in ("a", "b/c"):
            self.file(f"assets/{at}/new/left.obj", square())
        self.file("made/left.obj", square())
        self.file("deep/a/b/mesh.obj", square())
        self.commit()
        self.assertEqual(self.lost("parts/*.obj", "parts/{name}", "app/[id]/gates.yaml"), {"app/[id]/parts/lost.obj"})
        self.assertEqual(self.lost("assets/**/new/*.obj", "assets/{dir}/../golden/{name}"),
                         {"assets/a/golden/lost.obj", "assets/b/c/golden/lost.obj"})
        self.assertEqual(self.lost("made/*.obj", "base/{name}"), {"Base/left.obj", "Base/lost.obj", "Base/lost one .obj"})
        self.assertEqual(self.lost("links/*.obj", "links/{name}"), {"links/lost.obj", "links/link.obj"})
        self.assertEqual(self.lost("deep/**/mesh.obj", "flatter/{dir}.obj"), {"flatter/c/d.obj"})
        self.assertEqual(self.lost("made/*.obj", str(self.folder / "links/{name}")), {"links/lost.obj", "links/link.obj"})
        self.assertEqual(self.lost("deep/**/mesh.obj", "flatter/../flatter/{dir}.obj"), {"flatter/c/d.obj"})
        self.assertEqual(self.lost("links/*.obj", f"../{self.folder.name}/links/{{name}}"), {"links/lost.obj", "links/link.obj"})
        self.assertEqual(self.lost("names/*.obj", "names/{name}"), {"names/a\x01.obj"})
        names = {gate["name"] for gate in self.report(3, "gates.yaml", "--against", "HEAD~1")["gates"]}
        self.assertIn("HEAD~1:names/a%01.obj", names)

    def test_a_lost_file_that_is_called_as_a_baseline(self):
        """The work tree's file of that name is never read in place of the baseline."""
        self.file("part.obj", square())
        self.file("HEAD:part.obj", square(2.0))
        self.file("sub/other.obj", square())
        self.commit()
        self.file("gates.yaml", "version: 1\ngates:\n  - {name: '{stem}', candidate: 'p*.obj', baseline: '{name}', max_distance: 1}\n"
                  "  - {name: 'own {stem}', candidate: 'sub/*.obj', baseline: 'HEAD:{stem}.obj', max_distance: 1}\n")
        found = {gate["name"]: gate for gate in self.report(3, "gates.yaml", "--against", "HEAD")["gates"]}
        self.assertEqual(found["part"]["verdict"], "pass")
        self.assertEqual(found["HEAD:HEAD:part.obj"]["verdict"], "error")

    def test_a_new_part_is_not_said_to_be_another_one_that_is_still_there(self):
        self.file("lod0/chair.obj", square())
        self.commit()
        self.file("lod1/chair.obj", square())
        self.assertIn("it is new, or had another name there", self.error_of(
            "lod1/chair.obj", "--against", "HEAD", "--max-distance", "1 mm"))

    def test_a_partial_clone_lacks_a_baseline(self):
        for name, height in (("here", 0.1), ("lacking", 0.2), ("another", 0.3)):
            self.file(f"{name}.obj", square(height))
        self.commit()
        for name in ("lacking", "another"):
            self.file(f"{name}.obj", square(0.5))
        self.commit()
        self.git("config", "uploadpack.allowFilter", "true")
        self.git("clone", "--quiet", "--filter=blob:none", f"file://{self.folder}", "clone")
        self.file("clone/gates.yaml", "version: 1\ngates:\n  - {name: '{stem}', candidate: '*.obj', baseline: '{name}', max_distance: 1}\n")
        report = self.report(3, "clone/gates.yaml", "--against", "HEAD~1")
        found = {gate["name"]: gate for gate in report["gates"]}
        self.assertEqual({name for name, gate in found.items() if gate["verdict"] == "pass"}, {"flat", "raised", "here"})
        told = found["lacking"]["error"]["message"]
        self.assertIn("its content is not in this partial clone", told)
        self.git("cat-file", "-e", re.search("'git cat-file -e ([0-9a-f]{40})'", told)[1], folder="clone")
        self.assertEqual(self.verdicts(0, "clone/gates.yaml", "--against", "HEAD~1", "--only", "lacking"), {"lacking": "pass"})

    def test_a_repository_of_another_user(self):
        self.file("part.obj", square())
        self.commit()
        result = self.exits(3, "part.obj", "--against", "HEAD", "--max-distance", "1", environment={
            "GIT_TEST_ASSUME_DIFFERENT_OWNER": "1", **IDENTITY})
        self.assertIn("trust it by 'git config --global --add safe.directory", result.stderr)

    def test_a_scene_has_the_files_beside_it(self):
        for size in (1, 2):
            text, data = scene("data/points.bin", size)
            self.file("scene.gltf", text)
            self.file("data/points.bin", data)
            self.commit()
        self.assertEqual(self.verdicts(0, "scene.gltf", "--against", "HEAD", "--max-distance", "1 mm"), {"scene.gltf": "pass"})
        self.assertEqual(self.verdicts(1, "scene.gltf", "--against", "HEAD~1", "--max-distance", "1 mm"), {"scene.gltf": "fail"})
        self.git("rm", "--quiet", "--cached", "data/points.bin")
        self.git("commit", "--quiet", "--message=lost")
        self.assertIn("needs 'data/points.bin' beside it, which is not in HEAD", self.error_of(
            "scene.gltf", "--against", "HEAD", "--max-distance", "1 mm"))

    def test_worktrees_and_hostile_names(self):
        name = "a\n::error::\u202e <b>.obj"
        self.file(name, square())
        self.commit()
        self.git("worktree", "add", "--quiet", "tree", "HEAD")
        self.file("tree/" + name, square(2.0))
        done = subprocess.run([BINARY, "check", name, "--against", "main", "--max-distance", "1"], env=ENVIRONMENT,
                              cwd=self.folder / "tree", capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1, done.stderr)
        for line in (done.stdout + done.stderr).splitlines():
            self.assertFalse(line.startswith("::"), line)
            self.assertNotIn("\u202e", line)

    def test_what_is_no_revision(self):
        self.file("part.obj", square())
        one = ("part.obj", "--max-distance", "1")
        self.fails(*one, "--against", "HEAD", saying="there is no commit 'HEAD'")  # no commit yet
        self.commit()
        for ref in ("nowhere", "HEAD~9", "HEAD:part.obj", "HEAD $(touch made)", "HEAD;touch made"):
            self.fails(*one, f"--against={ref}", saying="--against: there is no commit")
        for ref in ("-HEAD", "--output=made", "--all"):
            self.fails(*one, f"--against={ref}", saying="begins with '-'")
        self.fails(*one, "--against=", saying="--against: 1 required TEXT missing")
        self.assertFalse((self.folder / "made").exists())
        for name in ("GIT_DIR", "GIT_OBJECT_DIRECTORY", "GIT_COMMON_DIR", "GIT_INDEX_FILE", "GIT_TRACE"):
            self.exits(0, *one, "--against", "HEAD", environment={name: str(self.folder / "nowhere")})
        self.assertFalse((self.folder / "nowhere").exists())
        shutil.rmtree(self.folder / ".git")
        self.fails(*one, "--against", "HEAD", saying="--against: needs the git repository")

    def hostile_repository(self, folder, more=""):
        """Files that git takes for a repository, whose objects are to be fetched by a command."""
        self.file(f"{folder}/HEAD", "ref: refs/heads/main\n")
        self.file(f"{folder}/objects/x", "x")
        self.file(f"{folder}/refs/heads/main", "1" * 40 + "\n")
        self.file(f"{folder}/config", "[core]\n repositoryformatversion = 1\n bare = false\n"
                  f" sshCommand = touch '{self.folder}/made'\n{more}[extensions]\n partialClone = origin\n"
                  "[remote \"origin\"]\n url = ssh://x/y\n promisor = true\n")

    def test_no_command_of_a_repository_is_run(self):
        self.hostile_repository("sub", " worktree = ..\n")
        self.file("sub/part.obj", square())
        self.manifest([("part", "part.obj", "part.obj", "1 mm")], name="sub/gates.yaml")
        self.commit()
        self.fails("sub/gates.yaml", "--against", "main", saying="--against: needs the git repository")
        shutil.rmtree(self.folder / ".git")  # an archive may hold one
        self.hostile_repository(".git")
        self.fails("flat.obj", "--max-distance", "1", "--against", "main", saying="--against: there is no commit")
        self.assertFalse((self.folder / "made").exists())

    def test_a_file_that_is_called_as_a_baseline(self):
        self.file("part.obj", square())
        self.commit()
        self.file("main:part.obj", square(2.0))
        self.exits(1, "main:part.obj", "part.obj", "--against", "main", "--max-distance", "1")
        self.exits(1, "flat.obj", "main:part.obj", "--max-distance", "1")
        self.manifest([("same", "part.obj", "part.obj", "1"), ("other", "'main:part.obj'", "flat.obj", "1")])
        self.assertEqual(self.verdicts(1, "gates.yaml", "--against", "main"), {"same": "pass", "other": "fail"})

    def test_links_of_the_work_tree_are_not_followed(self):
        self.file("baselines/lid.obj", square())
        self.file("alt/lid.obj", square(2.0))
        self.commit()
        shutil.rmtree(self.folder / "baselines")
        (self.folder / "baselines").symlink_to("alt")
        self.manifest([("lid", "raised.obj", "baselines/lid.obj", "1 mm")])
        self.exits(0, "gates.yaml")
        report = self.report(1, "gates.yaml", "--against", "main")
        self.assertEqual(report["gates"][0]["baseline"], "main:baselines/lid.obj")
        with tempfile.TemporaryDirectory() as elsewhere:  # a link to the work tree is followed
            (pathlib.Path(elsewhere) / "tree").symlink_to(self.folder)
            self.exits(1, f"{elsewhere}/tree/gates.yaml", "--against", "main")
            self.exits(1, "raised.obj", f"{elsewhere}/tree/baselines/lid.obj", "--max-distance", "1", "--against", "main")

    def test_content_of_git_lfs_is_that_of_the_pointer(self):
        digest, pointer = pointer_of(square(2.0))
        self.file("part.obj", pointer)
        self.commit()
        self.file("part.obj", square())
        self.file(f".git/lfs/objects/{digest[:2]}/{digest[2:4]}/{digest}", square())
        self.assertIn("has another content in the store of Git LFS", self.error_of(
            "part.obj", "--against", "HEAD", "--max-distance", "1 mm"))

    def test_a_scene_that_names_itself(self):
        self.file("s.bin", scene("s.bin", 1)[0])
        self.file("part.obj", square())
        self.commit()
        self.manifest([("part", "part.obj", "part.obj", "1"), ("scene", "part.obj", "s.bin", "1")])
        report = json.loads(self.check("gates.yaml", "--against", "HEAD", "--json").stdout)
        self.assertEqual(report["gates"][0]["verdict"], "pass")

    def test_a_git_that_does_not_end(self):
        room = self.folder / "room"
        room.mkdir()
        self.file("part.obj", square())
        self.commit()
        git = pathlib.Path(self.file("bin/git", '#!/bin/sh\ncase " $* " in *" cat-file "*) : >begun; exec sleep 1000;; esac\n'
                                     f'exec {shutil.which("git")} "$@"\n'))
        git.chmod(0o755)
        signs = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

        def heed():  # also where these tests run in the background
            for sign in signs:
                signal.signal(sign, signal.SIG_DFL)

        for sign in signs:
            process = self.start("part.obj", "--against", "HEAD", "--max-distance", "1", preexec_fn=heed, environment={
                "PATH": f"{git.parent}:{os.environ['PATH']}", "TMPDIR": str(room)})
            until((self.folder / "begun").exists)
            self.assertNotEqual(list(room.iterdir()), [])
            process.send_signal(sign)
            out, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 3, (out, err))
            self.assertIn("it was interrupted", err)
            self.assertEqual(list(room.iterdir()), [])
            (self.folder / "begun").unlink()

    def test_without_git(self):
        self.file("part.obj", square())
        self.commit()
        result = self.exits(3, "part.obj", "--max-distance", "1", "--against", "HEAD", environment={"PATH": str(self.folder)})
        self.assertIn("git: it is not installed", result.stderr)

    def test_nothing_is_left_behind(self):
        self.file("part.obj", square())
        self.commit()
        room = self.folder / "room"
        room.mkdir()
        self.exits(0, "part.obj", "--max-distance", "1", "--against", "HEAD", environment={"TMPDIR": str(room)})
        self.fails("part.obj", "--max-distance", "1", "--against", "nowhere", saying="no commit")
        self.assertEqual(list(room.iterdir()), [])
        result = self.exits(3, "part.obj", "--max-distance", "1", "--against", "HEAD", environment={"TMPDIR": str(room / "none")})
        self.assertIn("set the variable TMPDIR", result.stderr)


if __name__ == "__main__":
    unittest.main()
