// Point clouds: XYZ, and what of the other formats is one.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/api/formats/files.h"
#include "tests/api/formats/gltf_documents.h"
#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {
namespace {

const std::vector<Vec3> kPoints{{0, 0, 0}, {1.5, 0, 0}, {0, -2, 0}};
const std::string kLines = "0 0 0\n1.5 0 0\n0 -2 0\n";
const std::string kCloudVertices = "v 0 0 0\nv 1.5 0 0\nv 0 -2 0\n";

std::string cloud_ply(const std::string& elements, const std::string& more = "") {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + elements +
         "end_header\n" + kLines + more;
}

void check_cloud(const Result<ReadMesh>& result) {
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  CHECK(result->notes.cloud);
  CHECK(result->mesh.positions == kPoints);
  CHECK(result->mesh.triangles == points_as_triangles(3));
}

}  // namespace

TEST_CASE("cloud: XYZ has a point a line, and ignores what follows it") {
  check_cloud(read(kLines, "m.xyz"));
  CHECK(read(kLines, "m.XYZ.gz")->format == Format::xyz);
  check_cloud(read("\xEF\xBB\xBF# x y z\r\n\r\n 0\t0 0 0.5 -1 1\r1.5 +0 0.0e3 red # x\n\n#\n0 -2 0 nan", "m.xyz"));
  check_cloud(read(kLines, "m.xyz.gz"));
  CHECK(code(kLines, "") == ErrorCode::unsupported_format);
}

TEST_CASE("cloud: a damaged XYZ is refused with its line") {
  CHECK(refusal("0 0 0\n1 2\n", "m.xyz") == "line 2 of 'a': a point needs three coordinates");
  CHECK(refusal("0 0 # 0\n", "m.xyz") == "line 1 of 'a': a point needs three coordinates");
  CHECK(refusal("0,0,0\n", "m.xyz") == "line 1 of 'a': '0,0,0' is not a number");
  CHECK(refusal("\n1 2 3.\n1 2 3..\n", "m.xyz") == "line 3 of 'a': '3..' is not a number");
  CHECK(refusal("0 nan 0\n", "m.xyz") == "line 1 of 'a': the coordinate 'nan' is not finite");
  CHECK(refusal("0 0 -inf\n", "m.xyz") == "line 1 of 'a': the coordinate '-inf' is not finite");
  CHECK(code("0 0 1e999\n", "m.xyz") == ErrorCode::non_finite_vertex);
  CHECK(code("0 0 1e308\n", "m.xyz") == ErrorCode::coordinate_too_large);
  CHECK(refusal("# nothing\n\n", "m.xyz") == "'a' has no points");
  CHECK(code("# nothing\n", "m.xyz") == ErrorCode::empty_mesh);
  CHECK(contains(refusal(std::string("\1\2\0\3", 4), "m.xyz"), "binary data, not xyz"));
  CHECK(refusal(std::string(5000, '\n') + std::string("0 0 0 \0 1", 9), "m.xyz") ==
        "line 5001 of 'a': binary data in a text file");
  CHECK(refusal("3\na molecule\nC 0 0 0\n", "m.xyz") == "line 2 of 'a': 'a' is not a number");
}

TEST_CASE("cloud: a heading and a count before the points of an XYZ are noted") {
  const auto remarks = [](const std::string& before) {
    const auto result = read(before + kLines, "m.xyz");
    CAPTURE(before);
    check_cloud(result);
    return result->notes.remarks;
  };
  const std::string skipped = "skipped before the points: the ";
  for (const char* heading : {"//X Y Z", "// x y z", "//X Y Z Rf Gf Bf Scalar_field", "X Y Z", "x\ty\tz\tnx"}) {
    const std::string shown = "'" + std::string(heading) + "'";
    const bool tabs = contains(heading, "\t");
    CHECK(remarks(heading + std::string("\r\n")) ==
          std::vector<std::string>{skipped + "heading " + (tabs ? "'x?y?z?nx'" : shown)});
  }
  CHECK(remarks("3\n") == std::vector<std::string>{skipped + "count 3"});
  CHECK(remarks("\xEF\xBB\xBF\n//X Y Z\n 3 \n") ==
        std::vector<std::string>{skipped + "heading '//X Y Z'", skipped + "count 3"});
  CHECK(remarks("3\n//X Y Z\n").size() == 2);
  for (const char* comment : {"# X Y Z\n", "# scan\n#\n", "# columns: z y x\n", "#x y z i\n"}) {
    CHECK(remarks(comment).empty());
  }
  CHECK(refusal("0 0 0\n//X Y Z\n", "m.xyz") == "line 2 of 'a': '//X' is not a number");
  CHECK(refusal("//X Y Z\n//X Y Z\n0 0 0\n", "m.xyz") == "line 2 of 'a': '//X' is not a number");
}

TEST_CASE("cloud: a heading of other columns before the points of an XYZ is refused") {
  for (const char* heading : {"//Z Y X", "//R G B X Y Z", "//X Z Y", "//X,Y,Z", "//", "// a scan", "# Z Y X", "z y x",
                              "#R G B X Y Z", "#id x y z", "nx ny nz x y z"}) {
    CAPTURE(std::string(heading));
    CHECK(refusal("\n" + std::string(heading) + "\n" + kLines, "m.xyz") ==
          "line 2 of 'a': the heading '" + std::string(heading) +
              "' does not begin with the columns X Y Z, separated by blanks; write the columns in this order");
  }
  CHECK(refusal("C 0 0 0\n", "m.xyz") == "line 1 of 'a': 'C' is not a number");
}

TEST_CASE("cloud: a wrong count, or one as in a file of molecules, is refused") {
  CHECK(refusal("//X Y Z\n4\n" + kLines, "m.xyz") ==
        "line 2 of 'a': wrong count: the line says '4' points, the file has 3; write the file again, or remove this "
        "line");
  CHECK(code("2\n" + kLines, "m.xyz") == ErrorCode::unreadable_mesh);
  CHECK(contains(refusal("99999999999999999999999\n" + kLines, "m.xyz"), "wrong count"));
  CHECK(contains(refusal("3\n", "m.xyz"), "wrong count"));
  CHECK(code("0\n", "m.xyz") == ErrorCode::empty_mesh);
  CHECK(refusal("-3\n" + kLines, "m.xyz") == "line 1 of 'a': a point needs three coordinates");
  CHECK(refusal("3\n3\n" + kLines, "m.xyz") == "line 2 of 'a': a point needs three coordinates");
  const std::string atoms = "6 0 0 0\n1 0 0 1\n1 0 1 0\n";  // the first column is the number of protons
  for (const char* line_end : {"\n", "\r\n", "\r"}) {
    for (const char* line : {"", " ", "# methylene"}) {
      CHECK(contains(refusal(std::string("3") + line_end + line + line_end + atoms, "m.xyz"),
                     "line 2 of 'a': an empty line or a comment after the count of points, as in files of molecules"));
    }
  }
}

TEST_CASE("cloud: NUL and 0x1A bytes after the last point are noted") {
  using namespace std::string_literals;
  for (const std::string& end : {"\0"s, "\n\0\n"s, "\x1A"s}) {
    const auto result = read(kLines + end, "m.xyz");
    check_cloud(result);
    CHECK(result->notes.remarks == std::vector<std::string>{"NUL or 0x1A bytes after the last line, ignored"});
  }
}

TEST_CASE("cloud: points beyond the limits are refused") {
  for (const auto& [vertices, triangles] : {std::pair<std::size_t, std::size_t>{2, 9}, {9, 2}}) {
    const ReadLimits limits{vertices, triangles, 1000};
    CHECK(contains(read(kLines, "m.xyz", limits).error().message, "more points than the limit of 2"));
    CHECK(read(kCloudVertices, "m.obj", limits).error().code == ErrorCode::too_large);
    CHECK(read(cloud_ply(""), "m.ply", limits).error().code == ErrorCode::too_large);
  }
}

TEST_CASE("cloud: an OBJ of vertices alone") {
  check_cloud(read("# scan\no part\ng a\n" + kCloudVertices + "vn 0 0 1\ns off\n", "m.obj"));
  for (const char* more : {"f 1 2 3\n", "f 1 1 1\n"}) CHECK(!read(kCloudVertices + more, "m.obj")->notes.cloud);
  // Lines, points and control points would have another shape than all vertices.
  for (const char* more : {"l 1 2\n", "p 1\n", "f 1 2\n", "cstype bezier\ncurv 0 1 1 2 3\n"}) {
    CHECK(refusal(kCloudVertices + more, "m.obj") == "'a' has no triangles");
  }
  for (const char* more : {"surf 0 1 0 1 1 2 3\n", "face 1 2 3\n", "call other.obj\n"}) {
    CHECK(code(kCloudVertices + more, "m.obj") == ErrorCode::unsupported_format);
  }
}

TEST_CASE("cloud: a PLY without faces, or with none of them") {
  const std::string list = "property list uchar int vertex_indices\n";
  check_cloud(read(cloud_ply(""), "m.ply"));
  check_cloud(read(cloud_ply("element face 0\n" + list), "m.ply"));
  check_cloud(read(cloud_ply("element tristrips 0\n" + list), "m.ply"));
  check_cloud(read(cloud_ply("element camera 1\nproperty float view_px\n", "1\n"), "m.ply"));
  CHECK(!read(cloud_ply("element face 1\n" + list, "3 0 1 2\n"), "m.ply")->notes.cloud);
  // Elements that may join the vertices, by whatever name.
  const std::string refused = "the PLY header of 'a': neither an element 'face' nor 'tristrips', so no triangles";
  CHECK(refusal(cloud_ply("element edge 1\nproperty int vertex1\nproperty int vertex2\n", "0 1\n"), "m.ply") ==
        refused);
  CHECK(refusal(cloud_ply("element faces 1\n" + list, "3 0 1 2\n"), "m.ply") ==
        "'a' has no triangles, only what is not read (elements 'faces': 1): export it as triangles");
  const std::string none = "element face 0\n" + list;
  CHECK(code(cloud_ply(none + "element polygon 1\n" + list, "3 0 1 2\n"), "m.ply") == ErrorCode::unsupported_format);
  CHECK(refusal(cloud_ply("element polygon 0\n" + list), "m.ply") == refused);
  CHECK(!read(cloud_ply(none + "element face 1\n" + list, "3 0 1 2\n"), "m.ply"));
  CHECK(code(cloud_ply("element face 1\n" + list, "2 0 1\n"), "m.ply") == ErrorCode::empty_mesh);
}

TEST_CASE("cloud: a glTF of points, placed by their nodes") {
  nlohmann::json document = tetrahedron();
  auto& primitives = document["meshes"][0]["primitives"];
  primitives = {{{"attributes", {{"POSITION", 0}}}, {"mode", 0}}};
  document["nodes"][0]["translation"] = {1, 2, 3};
  const auto cloud = read(glb(document), "");
  INFO((cloud ? "" : cloud.error().message));
  REQUIRE(cloud.ok());
  CHECK(cloud->notes.cloud);
  CHECK(cloud->notes.skipped_primitives == 0);
  CHECK(cloud->mesh.positions.size() == 4);
  CHECK(cloud->mesh.triangles == points_as_triangles(4));
  CHECK(cloud->mesh.positions[0] == mesh_of(glb(tetrahedron())).positions[0] + Vec3(1, 2, 3));

  primitives[0]["indices"] = 1;  // some points more than once
  const std::size_t indices = document["accessors"][1]["count"];
  CHECK(read(glb(document), "")->mesh.triangles.size() == indices);
  const nlohmann::json alone = document;
  primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  CHECK(refusal(glb(document), "") == "'a' has no triangles");
  primitives[1]["mode"] = 4;
  primitives[1]["indices"] = 1;
  CHECK(!read(glb(document), "")->notes.cloud);
  CHECK(read(glb(document), "")->notes.skipped_primitives == 1);
  document = alone;  // beside a mesh that is hidden
  document["meshes"].push_back(tetrahedron()["meshes"][0]);
  document["nodes"].push_back({{"mesh", 1}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  document["scenes"][0]["nodes"] = {0, document["nodes"].size() - 1};
  document["extensionsUsed"] = {"KHR_node_visibility"};
  CHECK(contains(refusal(glb(document), ""), "KHR_node_visibility hides 1 nodes with meshes"));
  document = alone;
  document["meshes"][0]["primitives"] = {{{"attributes", nlohmann::json::object()}, {"mode", 0}}};
  CHECK(contains(refusal(glb(document), ""), "no attribute POSITION"));
}

}  // namespace meshgauge::api::test
