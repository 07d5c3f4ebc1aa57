"""A cancel keeps what there is; DELETE is in test_jobs."""

import unittest

from harness import ServerCase, begin_slow, wait_for


class Cancel(ServerCase):
    flags = ("--workers", "2")

    def test_a_cancel_never_deletes(self):
        path = "/v1/comparisons/" + self.server.compare().headers["x-request-id"]
        ended = self.server.get(path).json()
        for _ in range(2):
            answer = self.server.send("POST", path + "/cancel")
            self.assertEqual((answer.status, answer.json()), (200, ended))
        running, _ = begin_slow(self.server)
        wait_for(self.server, running, "running")
        job = self.server.send("POST", running + "/cancel").json()
        self.assertEqual((job["state"], self.server.get(running).json()), ("cancelled", job))
        self.refused(self.server.send("POST", "/v1/comparisons/" + "0" * 32 + "/cancel"), 404, "not-found")
        self.refused(self.server.send("POST", path + "/cancel?x=1"), 400, "malformed-request")


if __name__ == "__main__":
    unittest.main()
