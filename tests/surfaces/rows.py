"""What can be asked, in every spelling, and every mistake: the options of one request each, as JSON.

`wholes` are accepted and have a limit; `mistakes` are refused. A moved cube is compared with a cube: their distance is 0.25.
"""

LENGTHS = ["0.3", "0.3 mm", ".3mm", "3e-1 mm", " 0.3   mm ", "0.3 Millimetres", "+0.3 mm", "0.03 cm", "0.0003 m", "300 um", "300 \u00b5m",
           "0.2 mm", "0.25 mm", "1 in", "1\"", "1 ft", "1 inch", "2 feet", "0.3 millimeter", "300 microns", "5 %", "10%", " 5e0 % ", 0.3, 1, 0,
           "0", "0 mm", "0 %"]
WRONG_LENGTHS = ["", " ", "mm", "0,3", "0,3 mm", "1 000 mm", "0x10", "1_0", "0.3.1", "--1", "nan", "inf mm", "1e999", "-0.3 mm", "-1 %",
                 "5 % mm", "5 mm %", "5 %%", "5 m2", "5 mm mm", "0.3 parsec", "5 percent", -1, True, [1], {"value": 1}]
TIMES = ["60 s", "60s", 60, "500 ms", "2 min", 1.5, "90", " 0.5 s ", "1e-1 min", 180]
WRONG_TIMES = ["", "s", "1 h", "1 m", "1 sec", "60 S", "1 min 30 s", "1:30", "nan", "0x1 s", "1,5 s", 0, "0.4 ms", -1, "181", "4 min", 181, True, [1]]
UNITS = ["mm", "MM", "Millimetres", "in", "inches", "\"", "m", "cm", "um", "ft", "foot", {"candidate": "mm", "baseline": "mm"},
         {"candidate": "in", "baseline": "mm"}]
BOX = {"min": [-9, -9, -9], "max": [0.3, 9, 9]}
BALL = {"centre": [1, 1, 1], "radius": 1.2}
IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def _unit_of(length):
    """A limit in the same unit, large and small."""
    if not isinstance(length, str):
        return 3
    unit = length.strip().lstrip("+").lstrip("0123456789.e-").strip()
    return f"300 {unit}" if unit else 3


def wholes():
    """On one thread, and without narrowing, which is a matter of time: the bits depend on the input alone."""
    steady = {"threads": 1, "narrow": False}
    return [{**steady, **row} for row in _wholes()]


def _wholes():
    rows = [{"max_distance": length} for length in LENGTHS]
    # Not at the distance itself, which a part of the area has: no search ends there.
    rows += [{"max_share_beyond": {"distance": length, "share": "20 %"}} for length in LENGTHS if length not in ("0.25 mm",)]
    rows += [{"max_share_beyond": {"distance": "0.1 mm", "share": share}} for share in ("0 %", "100%", " 1.5 % ", "5e1 %")]
    rows += [{"max_distance": _unit_of(length), "uncertainty": length} for length in LENGTHS]
    rows += [{"zone": [f"-{length.strip().lstrip('+')}", length]} for length in LENGTHS if isinstance(length, str)]
    rows += [{"zone": zone} for zone in ([-0.3, 0.3], [0, 0.3], [-0.3, 0], ["-0.3 mm", 0], [0, "+0.3 mm"], ["-1 %", "20 %"], [0, 0])]
    rows += [{"max_distance": _unit_of(length), "regions": [{"name": "left", "box": BOX, "max_distance": length}]} for length in LENGTHS]
    rows += [{"max_distance": "0.3 mm", "max_share_beyond": {"distance": "0.1 mm", "share": "1 %"}, "zone": ["-0.2 mm", "0.3 mm"],
              "regions": [{"name": "left", "box": BOX}, {"name": "ball", "sphere": BALL, "max_distance": "0.1 mm"}], "uncertainty": "0.01 mm"}]
    more = [{"direction": word} for word in ("symmetric", "a_to_b", "b_to_a", "candidate_to_baseline", "baseline_to_candidate")]
    more += [{"strategy": name} for name in ("auto", "four_point", "triangle_set", "n_point")]
    more += [{"strategy": "n_point", "points": points} for points in (4, 10, 31, 109, 409, 1585)]
    more += [{"timeout": time} for time in TIMES] + [{"threads": threads} for threads in (1, 2, 64)] + [{"units": units} for units in UNITS]
    more += [{"tolerance": tolerance} for tolerance in ({"absolute": 0.1}, {"diagonal": 1e-3}, {"relative": 0.5}, {"absolute": 0},
                                                        {"absolute": 0.1, "diagonal": 1e-9, "relative": 0.5})]
    more += [{"statistics": statistics} for statistics in (True, False, {"samples": 1000}, {"seed": 7}, {"samples": 2000, "seed": 3}, {})]
    more += [{"narrow": False}, {"narrow": True}]
    more += [{"align": align} for align in ("none", "rigid", {}, {"overlap": 0.9}, {"principal_axes": True}, {"fit": True},
                                            {"transform": {"row_major": IDENTITY}}, {"transform": {"column_major": IDENTITY}},
                                            {"transform": {"row_major": IDENTITY}, "fit": True})]
    more += [{"expect": expect} for expect in ({"watertight": True}, {"watertight": False}, {"oriented": True}, {"triangles": 12},
                                               {"triangles": {"max": 20}}, {"triangles": {"min": 13}}, {"triangles": {"min": 1, "max": 12}},
                                               {"degenerate": 0}, {"components": 1}, {"volume": {"within": "1 %"}},
                                               {"volume": {"min": 7, "max": 9}}, {"volume": {"max": 2, "within": "0%"}},
                                               {"watertight": True, "components": {"max": 2}, "volume": {"within": " 5e-1 % "}})]
    return rows + [{"max_distance": "0.3 mm", **one} for one in more]


def mistakes():
    rows = [{"max_distance": length} for length in WRONG_LENGTHS]
    rows += [{"max_share_beyond": {"distance": length, "share": "1 %"}} for length in WRONG_LENGTHS]
    rows += [{"max_share_beyond": {"distance": 1, "share": share}} for share in ("", "1", "1 mm", "%", "1 %%", "120 %", "-1 %")]
    rows += [{"max_share_beyond": limit} for limit in (1, "1 %", {}, {"distance": 1}, {"share": "1 %"}, {"distance": 1, "shar": "1 %"}, [])]
    rows += [{"max_distance": 3, "uncertainty": length} for length in WRONG_LENGTHS] + [{"max_distance": 1, "uncertainty": 2}]
    rows += [{"zone": zone} for zone in (1, "1", [], [1], [0, 0, 0], [0.1, 0.2], ["0.1 mm", "0.2 mm"], [-0.1, -0.2], ["-1 parsec", 1], [-1, "x"],
                                         ["-1 mm", "1 in"], {"inside": 1})]
    rows += [{"zone": [-1, 1], "direction": word} for word in ("b_to_a", "baseline_to_candidate")]
    rows += [{"max_distance": "1 mm", "uncertainty": "1 in"}, {"max_distance": "1 mm", "uncertainty": 0.1}, {"max_distance": 1, "uncertainty": "1 %"},
             {"max_distance": "1 mm", "max_share_beyond": {"distance": "1 in", "share": "1 %"}}, {"max_distance": 1, "zone": ["-1 mm", "1 mm"]}]
    rows += [{"max_distance": 1, "regions": regions} for regions in (
        1, "x", [], [1], {}, [{}], [{"name": "x"}], [{"box": BOX}], [{"name": "", "box": BOX}], [{"name": "rest", "box": BOX}],
        [{"name": 5, "box": BOX}], [{"name": "x", "box": BOX}, {"name": "x", "box": BOX}], [{"name": "x", "box": BOX, "sphere": BALL}],
        [{"name": "x", "box": {}}], [{"name": "x", "box": {"min": [0, 0, 0]}}], [{"name": "x", "box": {"min": [2, 0, 0], "max": [1, 1, 1]}}],
        [{"name": "x", "box": {"min": [0, 0], "max": [1, 1, 1]}}], [{"name": "x", "box": {"min": [0, "0", 0], "max": [1, 1, 1]}}],
        [{"name": "x", "sphere": {"centre": [0, 0, 0], "radius": -1}}], [{"name": "x", "sphere": {"centre": [0, 0, 0]}}],
        [{"name": "x", "sphere": 1}], [{"name": "x", "group": 5}], [{"name": "x", "group": ""}], [{"name": "x", "box": BOX, "layer": 1}],
        [{"name": "x", "box": BOX, "max_distance": "1 mm"}], [{"name": "x", "box": BOX, "max_distance": -1}])]
    rows += [{"max_share_beyond": {"distance": 1, "share": "1 %"}, "regions": [{"name": "x", "box": BOX, "max_distance": 1}]}]
    rows += [{"max_distance": 1, "direction": "a_to_b", "regions": [{"name": "x", "group": "g"}]}]
    more = [{"direction": word} for word in ("", "up", "symetric", 1, True, [1], {})] + [{"strategy": name} for name in ("", "best", "npoint", 1, [1])]
    more += [{"strategy": "n_point", "points": points} for points in (0, 5, 4.5, "4", -4, True, [4])] + [{"points": 4}, {"strategy": "auto", "points": 31}]
    more += [{"timeout": time} for time in WRONG_TIMES] + [{"threads": threads} for threads in (65, -1, 1.5, "2", "two", True, [1], {})]
    more += [{"tolerance": tolerance} for tolerance in (0.1, "x", {}, [1], {"relativ": 1}, {"absolute": -1}, {"absolute": "1"}, {"relative": True})]
    more += [{"statistics": statistics} for statistics in (1, "yes", [1], {"samples": 1}, {"samples": 1.5}, {"sample": 1}, {"seed": -1})]
    more += [{"narrow": narrow} for narrow in (1, "true", "yes", [1])]
    more += [{"units": units} for units in ("", "parsec", "m m", 1, True, [1], {"candidate": "parsec"}, {"candidat": "mm"})]
    more += [{"align": align} for align in (1, "stiff", "", [1], {"overlap": 0.05}, {"overlap": "all"}, {"overlapp": 1}, {"fit": 1}, {"fit": False},
                                            {"transform": {}}, {"transform": 1}, {"transform": {"rows": []}}, {"transform": {"row_major": [1, 2]}},
                                            {"transform": {"row_major": IDENTITY[:-1] + [2]}}, {"transform": {"row_major": [2] + IDENTITY[1:]}},
                                            {"transform": {"row_major": [-1] + IDENTITY[1:]}}, {"transform": {"row_major": IDENTITY}, "overlap": 0.5})]
    more += [{"expect": expect} for expect in (1, "watertight", {}, [1], {"water": True}, {"watertight": 1}, {"watertight": "true"}, {"triangles": "12"},
                                               {"triangles": -1}, {"triangles": {}}, {"triangles": [1]}, {"triangles": {"within": 1}},
                                               {"components": 1.5}, {"degenerate": {"min": 2, "max": 1}}, {"volume": 5}, {"volume": {"max": -1}},
                                               {"volume": {"within": "1 mm"}}, {"volume": {"within": "-1 %"}})]
    rows += [{"max_distance": 1, **one} for one in more]
    rows += [{"max_distance": "x", "threads": 65, "expect": {"triangles": -1, "watertight": 1}, "direction": "up"}]
    return rows + [{"max_distance": 1, "max_distnace": 1}, {"max_distance": 1, "colour": "red"}]
