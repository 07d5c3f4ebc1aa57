// Writes what fuzzing starts from: make_seeds FOLDER writes FOLDER/TARGET/NAME. Mesh files are those of
// tests/api/formats/small_files.cpp, so that a new format needs nothing here.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/api/formats/files.h"
#include "tests/api/formats/gltf_compressed.h"
#include "tests/api/formats/small_files.h"

namespace {

namespace fs = std::filesystem;
using meshgauge::api::test::raw;
using meshgauge::api::test::SmallFile;

class Seeds {
 public:
  explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}

  void write(const std::string& target, const std::string& name, const std::string& content) {
    fs::create_directories(folder_ / target);
    std::ofstream file(folder_ / target / name, std::ios::binary);
    file << content;
    good_ = good_ && file.flush().good();
  }
  bool good() const { return good_; }

 private:
  fs::path folder_;
  bool good_ = true;
};

// The JSON of a GLB and, behind a NUL, its data: what targets/glb.cpp puts together.
std::string taken_apart(const std::string& glb) {
  const std::size_t bin = glb.find(std::string("BIN\0", 4));
  return glb.substr(20, bin - 4 - 20) + '\0' + glb.substr(bin + 4);
}

// Streams by themselves, for the targets of their decoders, and the files that hold them.
void write_compressed(Seeds& seeds) {
  using namespace meshgauge::api::test;
  std::vector<float> positions;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < 30; ++i) {
    for (const std::uint32_t k : {i % 6, i / 6, i * i % 4}) positions.push_back(static_cast<float>(k));
    if (i % 6 == 5 || i > 23) continue;
    for (const std::uint32_t corner : {i, i + 1, i + 6, i + 1, i + 7, i + 6}) corners.push_back(corner);
  }
  for (const int speed : {0, 5, 10}) {
    for (const int bits : {0, 8}) {
      const std::string stream = draco_stream(positions, corners, bits, speed);
      const std::string name = "speed" + std::to_string(speed) + "_bits" + std::to_string(bits);
      seeds.write("draco", name, stream);
      seeds.write("glb", name + ".parts", taken_apart(draco_glb(stream)));
    }
  }
  const std::string meshopt = meshopt_glb("KHR_meshopt_compression");
  seeds.write("glb", "meshopt.glb", meshopt);
  seeds.write("glb", "meshopt.parts", taken_apart(meshopt));
  const std::string parts = taken_apart(meshopt);
  const std::size_t nul = parts.find('\0');
  const auto views = nlohmann::json::parse(parts.substr(0, nul))["bufferViews"];
  const std::size_t triangles = views[0]["extensions"]["KHR_meshopt_compression"]["byteLength"];
  const std::string streams = parts.substr(nul + 1);
  seeds.write("meshopt", "attributes", std::string("\0\x04\0\x02", 4) + streams.substr(0, triangles));
  seeds.write("meshopt", "triangles", std::string("\x01\x0C\0\x01", 4) + streams.substr(triangles));
  seeds.write("meshopt", "indices", std::string("\x02\x03\0\x01\xD1\x02\x04\x06\0\0\0\0", 12));
}

void write_meshes(Seeds& seeds) {
  for (const SmallFile& file : meshgauge::api::test::small_files()) {
    const std::string format = format_of(file);
    const bool is_gzip = file.name.ends_with(".gz");
    seeds.write(is_gzip ? "gzip" : format, file.name, file.content);
    seeds.write("detect", file.name, file.content);
    if (!is_gzip) seeds.write("gzip", file.name, file.content);
    if (format == "obj" && !is_gzip) seeds.write("obj_tinyobj", file.name, file.content);
    if (file.content.starts_with("PK") && format == "gltf") seeds.write("gltf_zip", file.name, file.content);
    if (format == "glb") seeds.write("glb", file.name + ".parts", taken_apart(file.content));
  }
  seeds.write("gltf_zip", "external.parts", meshgauge::api::test::small_scene_and_data());
  for (const auto& [name, content] : meshgauge::api::test::small_archives()) seeds.write("zip", name, content);
  seeds.write("3mf", "model.xml", meshgauge::api::test::small_model());
  seeds.write("3mf", "foreign.xml", meshgauge::api::test::small_foreign_model());
  const std::string separator(1, '\0');
  const std::string range = R"(<config><object id="1"><volume firstid="0" lastid="0"><metadata key="volume_type" )";
  const std::string part = R"(<config><object id="2"><part id="1" subtype=)";
  seeds.write("3mf", "volumes.xml",
              meshgauge::api::test::small_model() + separator + range +
                  R"(value="SupportBlocker"/></volume></object></config>)" + separator + part +
                  R"("modifier_part"/></object></config>)");
  std::string floats;
  for (int i = 0; i < 45; ++i) floats += raw(0.1F * static_cast<float>(i * i - 100));
  seeds.write("stl_admesh", "floats", floats);
}

// The layout (0: a grid, 1: with heights, 2: doubles), then the coordinates.
void write_polygons(Seeds& seeds) {
  using namespace std::string_literals;
  seeds.write("polygon", "notch", "\0\0\0\x08\0\x08\x08\x04\x02\0\x08"s);
  seeds.write("polygon", "crossing", "\0\0\0\x08\x08\x08\0\0\x08"s);
  seeds.write("polygon", "spike", "\0\0\0\x08\0\x0c\0\x08\0\x08\x08\0\x08"s);
  seeds.write("polygon", "hole", "\0\0\0\x09\0\x09\x09\0\x09\0\0\x02\x02\x02\x05\x05\x02\x02\x02"s);
  seeds.write("polygon", "warped", "\x01\0\0\0\x08\0\x01\x08\x08\0\x04\x09\x02\0\x08\x01"s);
  std::string doubles = "\x02";
  for (int i = 0; i < 15; ++i) doubles += raw(1e-3 * i * (i % 7) * (i % 5) - 1e200 * (i == 8));
  seeds.write("polygon", "doubles", doubles);
}

std::string part(const std::string& head, const std::string& data) {
  return "--XX\r\nContent-Disposition: form-data; " + head + "\r\n\r\n" + data + "\r\n";
}

void write_bodies(Seeds& seeds) {
  const std::string type = "multipart/form-data; boundary=XX\n";
  const std::string file = R"(name="a"; filename="x\"y.obj")"
                           "\r\nContent-Type: model/obj";
  const std::string whole = part(file, "v 0 0 0\r\n--X\r\n") + part(R"(name="b")", "") + part("name=options", "{}");
  seeds.write("multipart", "form", type + whole + "--XX--\r\n");
  const std::string files = part(R"(name="a.files"; filename="x.bin")", "abc") +
                            part(R"(name="a"; filename="s.gltf")", R"({"buffers": [{"uri": "x.bin"}]})") +
                            part(R"(name="a.files"; filename="sub/y.bin")", "") + part("name=b", "v 0 0 0\n");
  seeds.write("multipart", "files", type + files + "--XX--\r\n");
  seeds.write("multipart", "open", type + whole + "--XX\r\n");
  seeds.write("multipart", "quoted", "Multipart/Form-Data; charset=utf-8; boundary=\"a b\"\n--a b--\r\nepilogue");
  seeds.write("multipart", "preamble", type + "\r\nThis is a form.\r\n\r\n" + whole + "--XX--\r\n");
  seeds.write("multipart", "padding", type + "\r\n--XX \t\r\n" + whole.substr(6) + "--XX-- \r\nepilogue\r\n--XX--\r\n");
  seeds.write("multipart", "mark", type + "\xEF\xBB\xBF" + whole + "--XX--\r\n");
  seeds.write("multipart", "after_the_end", type + whole + "--XX--\r\n" + whole + "--XX--\r\n");
  seeds.write("multipart", "name_for_file",
              type + part("name=a", "part.stl") + part("name=b", "@my part.obj") + "--XX--\r\n");
  seeds.write("multipart", "other_names", type + part("name=file1", "v 0 0 0\n") + whole + "--XX--\r\n");
  seeds.write("multipart", "large", type + part(R"(name="a")", std::string(1200, 'x')) + "--XX--");
  seeds.write("body", "chunked", "c5\r\nhello\r\n1;ext=\"x\"\r\n \r\n005\r\nworld\r\n0\r\nTrailer: x\r\n\r\nNEXT");
  seeds.write("body", "sized", "\x05helloNEXT");
  seeds.write("body", "too_large", "cffffffff\r\n");
}

void write_requests(Seeds& seeds) {
  int number = 0;
  seeds.write("head", "get", "GET /healthz?x=1 HTTP/1.1\r\nHost: x\r\nConnection: keep-alive, close\r\n\r\n");
  seeds.write("head", "post",
              "POST http://host:80/v1/comparisons HTTP/1.1\r\nHost: x\r\nContent-Type: multipart/form-data; "
              "boundary=XX\r\nContent-Length: 12\r\nExpect: 100-continue\r\n\r\n");
  seeds.write("head", "chunked", "POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: Chunked\r\n\r\n");
  seeds.write("head", "old", "OPTIONS * HTTP/1.0\r\nContent-Encoding: identity\r\n\r\n");
  for (const char* target :
       {"/v1/comparisons?limit=5", "/%2e/..;a=b//:@?/?", "http://h?x=/metrics", "HTTPS://gauge.example:443/a?b",
        "http://[::1]:80", "http://user@host/", "http:///x", "*", "/%zz", "/|"}) {
    seeds.write("target", "target" + std::to_string(number++), target);
  }
  for (const char* host :
       {"localhost", "localhost:8080", "gauge_1.example:", ":80", "127.0.0.1:443", "127.0.0.01", "[::1]:8080",
        "[1:2:3:4:5:6:7::]", "[1:2:3:4:5:6:7:8]", "[::ffff:192.0.2.1]", "[::1].evil.example", "localhost:x.evil",
        "[fe80::1%25eth0]", "x@localhost", "loc%61lhost"}) {
    seeds.write("target", "host" + std::to_string(number++), host);
  }
  seeds.write("head", "incomplete", "GET / HTTP/1.1\nHost: x\n\n");
  seeds.write("options", "empty", "{}");
  seeds.write("options", "all",
              R"({"direction": "b_to_a", "tolerance": {"absolute": 0.25, "diagonal": 0.5, "relative": 1e-3},)"
              R"( "gate": {"max_distance": 2, "units": "mm"}, "strategy": "n_point", "points": 31, "timeout_ms": 90,)"
              R"( "threads": 7, "budget": {"work_items": 1000, "memory_bytes": 2097152}})");
  seeds.write("options", "regions",
              R"({"gate": {"max_distance": 2}, "regions": [{"name": "a", "box": {"min": [0, -1, 0], "max": [1, 1, 1]},)"
              R"( "max_distance": 1}, {"name": "b", "sphere": {"centre": [0, 0, 0], "radius": 5}}]})");
  seeds.write("options", "wrong", R"({"threads": 1, "threads": [{"\u0000": -0.0e+1}], "strategy": null})");
}

// Messages to the tools.
void write_messages(Seeds& seeds) {
  const auto call = [](const std::string& id, const std::string& tool, const std::string& arguments) {
    return R"({"jsonrpc":"2.0","id":)" + id + R"(,"method":"tools/call","params":{"name":")" + tool +
           R"(","arguments":)" + arguments + "}}\n";
  };
  const std::string triangle = R"({"name":"c.off","base64":"T0ZGCjMgMSAwCjAgMCAwCjEgMCAwCjAgMSAwCjMgMCAxIDIK"})";
  seeds.write("mcp", "session",
              R"({"jsonrpc":"2.0","id":0,"method":"initialize","params":{"protocolVersion":"2025-06-18"}})"
              "\n"
              R"({"jsonrpc":"2.0","method":"notifications/initialized"})"
              "\n"
              R"({"jsonrpc":"2.0","id":"x","method":"tools/list"})"
              "\n"
              R"({"jsonrpc":"2.0","id":2,"method":"ping"})");
  seeds.write("mcp", "pass",
              call("1", "compare_meshes",
                   R"({"a":{"path":"a.off"},"b":)" + triangle + R"(,"options":{"max_distance":"5 mm"}})"));
  seeds.write("mcp", "fail",
              call("1", "compare_meshes",
                   R"({"a":{"path":"a.off"},"b":{"path":"b.off"},"options":{"max_distance":0,"align":"rigid"}})"));
  seeds.write("mcp", "inspect", call("\"i\"", "inspect_mesh", R"({"mesh":)" + triangle + R"(,"unit":"mm"})"));
  seeds.write("mcp", "gates", call("7", "check_gates", R"({"manifest":"gates.yaml","only":["x"],"comparisons":true})"));
  seeds.write("mcp", "mistakes", call("8", "compare_meshes", R"({"a":{"path":"../x"},"options":{"threads":0},"c":1})"));
  seeds.write("mcp", "broken", "[]\n{\"id\":1}\n{\n" + call("9", "none", "{}"));
  seeds.write("mcp", "cancelled",
              R"({"jsonrpc":"2.0","method":"notifications/cancelled","params":{"requestId":1}})"
              "\n"
              R"({"jsonrpc":"2.0","id":3,"method":"tools/call","params":{"name":"check_gates",)"
              R"("_meta":{"progressToken":"t"}}})");
}

// Those that the tests of check/ read.
void write_manifests(Seeds& seeds) {
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(MESHGAUGE_SOURCE_DIR) / "tests/check/manifests")) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    seeds.write("manifest", entry.path().filename().string(), {std::istreambuf_iterator<char>(file), {}});
  }
  seeds.write("manifest", "limit", "0.05 mm");
  seeds.write("manifest", "duration", "1.5 min");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: make_seeds FOLDER\n"), 1;
  Seeds seeds{fs::path(argv[1])};
  write_meshes(seeds);
  write_compressed(seeds);
  write_polygons(seeds);
  write_bodies(seeds);
  write_requests(seeds);
  write_messages(seeds);
  write_manifests(seeds);
  if (!seeds.good()) return std::fprintf(stderr, "%s cannot be written\n", argv[1]), 1;
  return 0;
}
