"""The user of the chart's pods: the image's own, another one, or none, where the cluster chooses it (OpenShift)."""

import unittest

from chart import LEAST, Objects, complaints, helm, rendered


def setUpModule():
    helm()


class Users(unittest.TestCase):
    def test_the_cluster_may_choose_the_user(self):
        kept = {"runAsNonRoot": True, "seccompProfile": {"type": "RuntimeDefault"}}
        for asked, made in [
            (None, {}),
            ({"runAsUser": None, "fsGroup": None}, {"runAsGroup": 10001}),
            ({}, {"runAsUser": 10001, "runAsGroup": 10001, "fsGroup": 10001}),
            ({"runAsUser": 1000660000, "runAsGroup": 0}, {"runAsUser": 1000660000, "runAsGroup": 0, "fsGroup": 10001}),
        ]:
            found = Objects(rendered({**LEAST, "podSecurityContext": asked}))
            self.assertEqual(complaints(found), [])
            for o, template in found.pods():
                self.assertEqual(template["spec"]["securityContext"], {**kept, **made}, (asked, o["metadata"]["name"]))


if __name__ == "__main__":
    unittest.main()
