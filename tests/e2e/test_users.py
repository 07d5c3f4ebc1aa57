"""Any user of the image: a data folder of group 0, or of a group, with the rights of its owner, is used by one user after another."""

import hashlib
import os
import shutil
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

from harness import BINARY, ENVIRONMENT, EVERYBODYS, RAISED, SQUARE, Server
from maps import compared

IMAGES = 10001  # the user of the image
CHOSEN = 1000660000  # one that OpenShift chose
NEXT = 1000700000


def path_of(mesh):
    return "/v1/meshes/" + hashlib.sha256(mesh).hexdigest()


def rights(path):
    status = os.lstat(path)
    return status.st_gid, stat.S_IMODE(status.st_mode)


@unittest.skipIf(os.geteuid() != 0, "only root can become another user")
class Users(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(dir=EVERYBODYS)  # the one of the build may be closed to others
        self.addCleanup(folder.cleanup)
        os.chmod(folder.name, 0o755)
        self.binary = shutil.copy(BINARY, folder.name)
        self.data = Path(folder.name) / "data"
        self.environment = {"MESHGAUGE_DATA_DIR": str(self.data), "TMPDIR": EVERYBODYS}

    def volume(self, mode, user, group):
        self.data.mkdir()
        os.chown(self.data, user, group)
        self.data.chmod(mode)

    def program(self, user, group, umask):
        become = 'umask "$1"; shift; exec "$@"'
        return ["sh", "-c", become, "sh", umask, "setpriv", f"--reuid={user}", f"--regid={group}", "--clear-groups", "--", self.binary]

    def server(self, user, group=0, umask="022"):
        server = Server(environment=self.environment, program=self.program(user, group, umask))
        self.addCleanup(server.stop)
        return server

    def refused(self, user, group=0):
        done = subprocess.run([*self.program(user, group, "022"), "serve", "--port", "0"], capture_output=True, text=True,
                              env={**ENVIRONMENT, **self.environment}, timeout=120)
        self.assertEqual(done.returncode, 3, done.stderr)
        return done.stderr

    def work(self, server):
        """Stores meshes, compares them, and makes a map. The path of the comparison."""
        path, _ = compared(server, SQUARE, RAISED, {})
        self.assertEqual(server.get(path + "/deviation.ply").status, 200)
        return path

    def rights_within(self):
        """The distinct rights of all files, and of all folders."""
        files = {rights(path) for path in self.data.rglob("*") if path.is_file()}
        return files, {rights(path) for path in self.data.rglob("*") if path.is_dir()}

    def one_after_another(self, *users):
        """Each finds what the one before has kept, and can change it."""
        paths = []
        for user, group, umask in users:
            server = self.server(user, group, umask)
            for path in paths:
                self.assertEqual(server.get(path).json()["state"], "done")
            if paths:
                self.assertEqual(server.get(path_of(SQUARE), "HEAD").status, 200)
                self.assertEqual(server.send("PUT", path_of(SQUARE), SQUARE).status, 200)  # renewed
                self.assertEqual(server.send("DELETE", path_of(SQUARE)).status, 204)
                self.assertEqual(server.send("DELETE", paths.pop()).status, 204)
            paths.append(self.work(server))
            self.assertEqual(server.stop(), 0)

    def test_the_volume_of_the_image(self):
        self.volume(0o2770, IMAGES, 0)
        self.one_after_another((CHOSEN, 0, "022"), (NEXT, 0, "077"), (IMAGES, 0, "002"), (CHOSEN, 0, "022"))
        self.assertEqual(self.rights_within(), ({(0, 0o660)}, {(0, 0o2770)}))
        self.assertEqual(rights(self.data), (0, 0o2770))

    def test_what_the_documents_of_openshift_ask_for(self):
        self.volume(0o775, 0, 0)  # chgrp -R 0, chmod -R g=u
        self.one_after_another((CHOSEN, 0, "022"), (NEXT, 0, "022"))
        self.assertEqual(self.rights_within(), ({(0, 0o660)}, {(0, 0o770)}))

    def test_another_group(self):
        self.volume(0o2770, 0, 4321)
        self.one_after_another((CHOSEN, 4321, "022"), (NEXT, 4321, "022"))
        self.assertEqual(self.rights_within(), ({(4321, 0o660)}, {(4321, 0o2770)}))

    def test_other_folders_stay_their_users(self):
        for mode, user, group in ((0o700, CHOSEN, 0), (0o2700, CHOSEN, 4321), (0o2775, CHOSEN, 4321), (0o770, CHOSEN, 4321), (0o2777, 0, 0)):
            with self.subTest(oct(mode)):
                self.volume(mode, user, group)
                server = self.server(CHOSEN, group)
                self.work(server)
                self.assertEqual(server.stop(), 0)
                files, folders = self.rights_within()
                self.assertEqual({mode for _, mode in files}, {0o600})
                self.assertEqual({mode & 0o777 for _, mode in folders}, {0o700})
                shutil.rmtree(self.data)

    def test_a_folder_of_another_user(self):
        self.volume(0o700, IMAGES, IMAGES)
        data = str(self.data)
        self.assertEqual(
            self.refused(CHOSEN),
            f"meshgauge: the data folder '{data}' cannot be used: Permission denied; this process runs as user and group {CHOSEN}:0, "
            f"and '{data}' belongs to 10001:10001 with mode 0700: run as its owner (docker run --user 10001:10001), or give it to this "
            f"user (chown -R {CHOSEN}:0 '{data}') or to every user of group 0 (chgrp -R 0 '{data}' && chmod -R g=u '{data}')\n")

    def test_each_remedy(self):
        self.volume(0o700, IMAGES, IMAGES)
        self.work(server := self.server(IMAGES, IMAGES))
        self.assertEqual(server.stop(), 0)
        said = self.refused(CHOSEN)
        self.work(server := self.server(IMAGES, IMAGES))
        self.assertEqual(server.stop(), 0)
        share = said[said.index("(chgrp") + 1:said.rindex(")")]
        subprocess.run(["sh", "-c", share], check=True)
        self.one_after_another((CHOSEN, 0, "022"), (NEXT, 0, "022"))
        self.refused(CHOSEN, 4321)
        give = self.refused(CHOSEN, 4321).split("(chown")[1].split(")")[0]
        subprocess.run(["sh", "-c", "chown" + give], check=True)
        self.work(server := self.server(CHOSEN, 4321))
        self.assertEqual(server.stop(), 0)

    def test_a_place_where_no_folder_can_be_made(self):
        above = self.data.parent
        said = self.refused(CHOSEN)
        self.assertIn(f"the folder '{self.data}' cannot be made: Permission denied; this process runs as user and group {CHOSEN}:0, and "
                      f"'{above}' belongs to 0:0 with mode 0755: name another folder (MESHGAUGE_DATA_DIR), or give it to this user", said)

    def test_a_file_of_another_user(self):
        self.volume(0o2770, IMAGES, 0)
        self.work(server := self.server(IMAGES))
        self.assertEqual(server.stop(), 0)
        database = self.data / "jobs.sqlite"
        database.chmod(0o600)
        said = self.refused(CHOSEN)
        self.assertIn(f"'{database}' belongs to {IMAGES}:0 with mode 0600: run as its owner", said)
        self.assertIn(f"(chgrp -R 0 '{self.data}' && chmod -R g=u '{self.data}')", said)


if __name__ == "__main__":
    unittest.main()
