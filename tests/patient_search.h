// A search from one mesh to another whose monitor never stops it, for tests of the parts of a search.
#pragma once

#include <utility>

#include "engine/search/search.h"
#include "tree.h"

namespace meshgauge {

class Patient final : public Monitor {
  std::optional<Stop> pulse(const Search&) override { return std::nullopt; }
  bool interrupted() override { return false; }
};

struct PatientSearch {
  Mesh a, b;
  Bvh to;
  Patient monitor;
  ThreadPool pool{1};
  Search search;

  PatientSearch(Mesh a_in, Mesh b_in)
      : a(std::move(a_in)),
        b(std::move(b_in)),
        to(tree_of(b)),
        search(a, bounding_box(a), to, Goal{}, 0, monitor, pool) {}

  // Returns a whole triangle of `a`, with its corners measured.
  Piece piece(std::uint32_t triangle = 0) {
    Piece p;
    p.triangle = triangle;
    for (std::size_t i = 0; i < 3; ++i) {
      p.corners[i] = nearest_corner(to, a.positions[a.triangles[triangle][i]], search.work());
    }
    return p;
  }
};

}  // namespace meshgauge
