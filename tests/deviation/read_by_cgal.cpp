// What CGAL finds in a PLY, as JSON; the distance and the quality from its property maps.
#include <fstream>
#include <iostream>

#include <CGAL/IO/Color.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO/PLY.h>
#include <nlohmann/json.hpp>

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

int main(int argc, char** argv) {
  Mesh mesh;
  std::string comments;
  std::ifstream in(argc == 2 ? argv[1] : "", std::ios::binary);
  if (!CGAL::IO::read_PLY(in, mesh, comments)) return 1;
  const auto [distance, has_distance] = mesh.property_map<Mesh::Vertex_index, double>("v:distance");
  const auto [quality, has_quality] = mesh.property_map<Mesh::Vertex_index, float>("v:quality");
  const auto [colour, has_colour] = mesh.property_map<Mesh::Vertex_index, CGAL::IO::Color>("v:color");
  if (!has_distance || !has_quality || !has_colour) return 1;
  nlohmann::json found{{"comments", comments}};
  for (const auto v : mesh.vertices()) {
    const Point& p = mesh.point(v);
    found["positions"].push_back({p.x(), p.y(), p.z()});
    found["distance"].push_back(distance[v]);
    found["quality"].push_back(quality[v]);
    found["colours"].push_back({colour[v].red(), colour[v].green(), colour[v].blue()});
  }
  for (const auto f : mesh.faces()) {
    nlohmann::json corners;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) corners.push_back(v.idx());
    found["triangles"].push_back(corners);
  }
  std::cout << found << "\n";
}
