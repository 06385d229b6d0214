/// Grids of triangles: sheets, and tubes without ends.
#pragma once

#include <vector>

#include "foldproof/mesh.h"

namespace foldproof::testing {

/// Which corners of a cell its two triangles share: the first and the last, or the other two.
enum class Diagonal { FirstToLast, SecondToThird };

/// Rows of cells, two triangles each. Vertices, too, are numbered row after row.
struct Grid {
  Index columns, rows;
  bool closed = false;  ///< The last column's neighbor is the first.
  Diagonal diagonal = Diagonal::FirstToLast;

  /// Vertices in a row.
  Index width() const { return closed ? columns : columns + 1; }
  Index vertex_count() const { return width() * (rows + 1); }

  std::vector<Triangle> triangles() const {
    std::vector<Triangle> all;
    for (Index j = 0; j < rows; ++j) {
      for (Index i = 0; i < columns; ++i) {
        const Index a = j * width() + i, b = j * width() + (i + 1) % width(), c = a + width(),
                    d = b + width();
        const bool first_to_last = diagonal == Diagonal::FirstToLast;
        all.push_back({a, b, first_to_last ? d : c});
        all.push_back(first_to_last ? Triangle{a, d, c} : Triangle{b, d, c});
      }
    }
    return all;
  }

  /// Several copies, the vertices of one after those of the other.
  Topology topology(Index copies = 1) const {
    std::vector<Triangle> all;
    for (Index first = 0; first < copies * vertex_count(); first += vertex_count()) {
      for (const Triangle& t : triangles()) all.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return Topology::make(copies * vertex_count(), std::move(all)).value();
  }

  /// `place` gives three coordinates for (u, v): u in [0,1] along a row, v in [0,1] from row to row.
  template <class Place>
  std::vector<double> positions(Place place) const {
    std::vector<double> x;
    for (Index j = 0; j <= rows; ++j) {
      for (Index i = 0; i < width(); ++i) {
        const auto p = place(double(i) / columns, double(j) / rows);
        x.insert(x.end(), {p[0], p[1], p[2]});
      }
    }
    return x;
  }
};

}  // namespace foldproof::testing
