#pragma once

#include <array>
#include <cstdint>

namespace cloister {

/// The triangles of one marching cube for each of the 256 ways its corners can be free or occupied.
///
/// Corner c of a cube sits at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e runs along axis e / 4 from
/// its lower corner.
///
/// The cases are derived, not listed. Walk around each face of the cube, counter-clockwise as seen
/// from outside: every run of free corners is cut off by one segment, directed from the edge where
/// the run is left to the edge where it was entered. Two diagonal free corners are therefore always
/// separated and the occupied ones joined, so a wall that is one voxel thick has no holes where it
/// runs diagonally. As the rule looks at one face only, both cubes at a face agree, and draw the
/// segment in opposite directions. Every cut edge starts one segment and ends another, so the
/// segments close to loops around the cube. A loop is split into triangles by diagonals that never
/// join two edges of one face: such a diagonal could coincide with one of the next cube. Hence each
/// side of a triangle belongs to exactly two triangles wherever the surface does not end at unknown
/// space.
struct CubeCase {
  static constexpr int kMaxTriangles = 5;

  std::uint8_t num_triangles = 0;
  std::array<std::array<std::uint8_t, 3>, kMaxTriangles>
      triangles{};  ///< edges, counter-clockwise from free space
};

/// The lower corner of an edge.
[[nodiscard]] constexpr int lower_corner(int edge) {
  const int axis = edge / 4;
  const int first = (axis + 1) % 3;
  const int second = (axis + 2) % 3;
  return (edge & 1) << first | (edge >> 1 & 1) << second;
}

namespace cube_cases_detail {

/// The edge between two corners that differ along one axis.
[[nodiscard]] constexpr int edge_between(int a, int b) {
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  const int first = (axis + 1) % 3;
  const int second = (axis + 2) % 3;
  return axis * 4 + ((a >> first & 1) | (a >> second & 1) << 1);
}

/// True when some face of the cube contains both edges.
[[nodiscard]] constexpr bool share_face(int edge_a, int edge_b) {
  const int a0 = lower_corner(edge_a), a1 = a0 | 1 << edge_a / 4;
  const int b0 = lower_corner(edge_b), b1 = b0 | 1 << edge_b / 4;
  return (a0 & a1 & b0 & b1) != 0 || (~a0 & ~a1 & ~b0 & ~b1 & 7) != 0;
}

struct Loop {
  std::array<std::uint8_t, 12> edges{};
  int size = 0;
};

/// Cuts ears off the loop until nothing is left, going back where a choice leads to a forbidden
/// diagonal.
constexpr bool triangulate(const Loop& loop, CubeCase& out) {
  const auto next = [&](int i) { return (i + 1) % loop.size; };
  const auto emit = [&](int i) {
    out.triangles[out.num_triangles++] = {loop.edges[i], loop.edges[next(i)],
                                          loop.edges[next(next(i))]};
  };
  if (loop.size == 3) {
    emit(0);
    return true;
  }
  for (int i = 0; i < loop.size; ++i) {
    if (share_face(loop.edges[i], loop.edges[next(next(i))])) continue;
    const int num_before = out.num_triangles;
    emit(i);
    Loop rest;
    for (int k = 0; k < loop.size; ++k) {
      if (k != next(i)) rest.edges[rest.size++] = loop.edges[k];
    }
    if (triangulate(rest, out)) return true;
    out.num_triangles = static_cast<std::uint8_t>(num_before);
  }
  return false;
}

/// @param occupied bit c tells whether corner c is occupied
constexpr bool make_case(int occupied, CubeCase& out) {
  constexpr int kNone = -1;
  std::array<int, 12> segment_end{};
  segment_end.fill(kNone);
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << (axis + 1) % 3;
    const int v = 1 << (axis + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      const int base = side << axis;
      const std::array<int, 4> corners = side == 1
                                             ? std::array{base, base | u, base | u | v, base | v}
                                             : std::array{base, base | v, base | u | v, base | u};
      const auto is_free = [&](int i) { return (occupied >> corners[i % 4] & 1) == 0; };
      const auto edge = [&](int i) { return edge_between(corners[i % 4], corners[(i + 1) % 4]); };
      for (int i = 0; i < 4; ++i) {
        if (is_free(i) || !is_free(i + 1)) continue;  // a run of free corners is entered by edge i
        int last = i + 1;
        while (is_free(last + 1)) ++last;
        segment_end[edge(last)] = edge(i);
      }
    }
  }
  for (int start = 0; start < 12; ++start) {
    Loop loop;
    for (int e = start; segment_end[e] != kNone;) {
      loop.edges[loop.size++] = static_cast<std::uint8_t>(e);
      const int following = segment_end[e];
      segment_end[e] = kNone;
      e = following;
    }
    if (loop.size > 0 && !triangulate(loop, out)) return false;
  }
  return true;
}

struct Table {
  std::array<CubeCase, 256> cases{};
  bool is_complete = true;  ///< every case could be triangulated without a forbidden diagonal
};

constexpr Table make_table() {
  Table table;
  for (int occupied = 0; occupied < 256; ++occupied) {
    table.is_complete = make_case(occupied, table.cases[occupied]) && table.is_complete;
  }
  return table;
}

inline constexpr Table kTable = make_table();
static_assert(kTable.is_complete);

}  // namespace cube_cases_detail

/// Bit c of the index tells whether corner c is occupied.
inline constexpr const std::array<CubeCase, 256>& kCubeCases = cube_cases_detail::kTable.cases;

}  // namespace cloister
